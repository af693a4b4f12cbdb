use std::fmt;

use foveasim_models::{Nanos, Provenance, Sample, Series};

/// Samples that pass by: each is read when first asked for, and dropped when every reader has let go of
/// it, so that a recording of any length fits in memory.
pub trait SampleWindow<T> {
    /// What the numbers are.
    fn provenance(&self) -> Provenance;

    /// A new reader, which may ask for every sample not yet let go of by all others. Readers enter before
    /// the first sample is released.
    fn enter(&self) -> usize;

    /// Sample `index`, counted from the first of all; `None` after the last.
    fn get(&self, index: usize) -> Option<Sample<T>>;

    /// `reader` will not ask for samples before `index` any more.
    fn release(&self, reader: usize, index: usize);
}

/// Where the samples of a series are: in memory, or passing by.
pub enum Samples<'a, T> {
    /// All of them in memory.
    Series(&'a Series<T>),
    /// Read as they are needed.
    Window(&'a dyn SampleWindow<T>),
}

impl<T> Clone for Samples<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Samples<'_, T> {}

impl<T> fmt::Debug for Samples<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Series(_) => "Series",
            Self::Window(_) => "Window",
        })
    }
}

impl<'a, T> From<&'a Series<T>> for Samples<'a, T> {
    fn from(series: &'a Series<T>) -> Self {
        Self::Series(series)
    }
}

impl<T: foveasim_models::Interpolate> Samples<'_, T> {
    /// What the numbers are.
    pub fn provenance(&self) -> Provenance {
        match self {
            Self::Series(series) => series.provenance(),
            Self::Window(window) => window.provenance(),
        }
    }

    /// Sample `index`; `None` after the last.
    pub fn get(&self, index: usize) -> Option<Sample<T>> {
        match self {
            Self::Series(series) => series.samples().get(index).copied(),
            Self::Window(window) => window.get(index),
        }
    }

    /// The time of sample `index`; `None` after the last.
    pub fn time(&self, index: usize) -> Option<Nanos> {
        match self {
            Self::Series(series) => series.samples().get(index).map(|s| s.t),
            Self::Window(window) => window.get(index).map(|s| s.t),
        }
    }
}
