use foveasim_models::math::quantile_sorted;
use foveasim_models::{Interpolate, Rate, Series};

/// The usual time between samples \[ms\]: that of the rate the file `stated`, or else the median of the intervals
/// between different times; NaN if there are none.
///
/// An excerpt leaves samples out: of one that states its rate the median says nothing.
pub(crate) fn usual_interval_ms<T: Interpolate>(series: &Series<T>, stated: Option<Rate>) -> f64 {
    if let Some(rate) = stated {
        return 1e3 / rate.hz();
    }
    quantile_sorted(&intervals_ms(series), 0.5)
}

/// The intervals between different times \[ms\], shortest first.
pub(crate) fn intervals_ms<T: Interpolate>(series: &Series<T>) -> Vec<f64> {
    let times = series.samples().windows(2);
    let mut intervals: Vec<f64> = times
        .map(|w| (w[1].t - w[0].t).as_ms())
        .filter(|ms| *ms > 0.0)
        .collect();
    intervals.sort_by(f64::total_cmp);
    intervals
}
