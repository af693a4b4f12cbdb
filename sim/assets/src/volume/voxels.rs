/// Stored values of voxels, in the type that their file has: x runs fastest, then y, then z.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Voxels {
    /// Unsigned, 8 bits.
    U8(Vec<u8>),
    /// Signed, 8 bits.
    I8(Vec<i8>),
    /// Unsigned, 16 bits.
    U16(Vec<u16>),
    /// Signed, 16 bits.
    I16(Vec<i16>),
    /// Unsigned, 32 bits.
    U32(Vec<u32>),
    /// Signed, 32 bits.
    I32(Vec<i32>),
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
}

/// A number that a voxel may be.
pub(super) trait Voxel: Copy {
    /// Its value.
    fn value(self) -> f64;
}

macro_rules! voxel {
    ($($t:ty),*) => {$(
        impl Voxel for $t {
            #[inline]
            fn value(self) -> f64 {
                f64::from(self)
            }
        }
    )*};
}

voxel!(u8, i8, u16, i16, u32, i32, f32, f64);

/// Does the same with voxels of whatever type.
macro_rules! each {
    ($voxels:expr, $v:ident => $body:expr) => {
        match $voxels {
            $crate::volume::voxels::Voxels::U8($v) => $body,
            $crate::volume::voxels::Voxels::I8($v) => $body,
            $crate::volume::voxels::Voxels::U16($v) => $body,
            $crate::volume::voxels::Voxels::I16($v) => $body,
            $crate::volume::voxels::Voxels::U32($v) => $body,
            $crate::volume::voxels::Voxels::I32($v) => $body,
            $crate::volume::voxels::Voxels::F32($v) => $body,
            $crate::volume::voxels::Voxels::F64($v) => $body,
        }
    };
}

impl Voxels {
    /// How many there are.
    pub fn len(&self) -> usize {
        each!(self, v => v.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether they are whole numbers.
    pub fn is_integer(&self) -> bool {
        !matches!(self, Self::F32(_) | Self::F64(_))
    }

    /// Memory that they take \[bytes\].
    pub fn bytes(&self) -> usize {
        each!(self, v => size_of_val(v.as_slice()))
    }

    /// The `index`-th.
    ///
    /// # Panics
    /// If there is none.
    pub fn get(&self, index: usize) -> f64 {
        each!(self, v => v[index].value())
    }

    /// Calls `f` with the voxels from `first` on, `count` of them, each with its place among these.
    ///
    /// # Panics
    /// If there are not that many.
    pub fn for_each(&self, first: usize, count: usize, mut f: impl FnMut(usize, f64)) {
        each!(self, v => {
            for (k, voxel) in v[first..first + count].iter().enumerate() {
                f(k, voxel.value());
            }
        });
    }

    /// Least and greatest of those that are finite, and how many are not.
    pub(super) fn finite_range(&self) -> (Option<[f64; 2]>, usize) {
        let (mut least, mut most, mut bad) = (f64::INFINITY, f64::NEG_INFINITY, 0);
        self.for_each(0, self.len(), |_, x| {
            if x.is_finite() {
                least = least.min(x);
                most = most.max(x);
            } else {
                bad += 1;
            }
        });
        ((least <= most).then_some([least, most]), bad)
    }

    /// Replaces what is not finite.
    pub(super) fn replace_non_finite(&mut self, by: f64) {
        match self {
            Self::F32(v) => v
                .iter_mut()
                .filter(|x| !x.is_finite())
                .for_each(|x| *x = by as f32),
            Self::F64(v) => v
                .iter_mut()
                .filter(|x| !x.is_finite())
                .for_each(|x| *x = by),
            _ => {}
        }
    }
}
