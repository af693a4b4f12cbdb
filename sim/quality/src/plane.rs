use foveasim_models::Image;
use glam::UVec2;

use crate::QualityError;

/// One finite number per pixel, row by row from the top-left.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    size: UVec2,
    values: Vec<f64>,
}

impl Plane {
    /// A plane of `size` pixels.
    ///
    /// # Errors
    /// If it has no pixels, not one value per pixel, or a value that is not finite.
    pub fn new(size: UVec2, values: Vec<f64>) -> Result<Self, QualityError> {
        let pixels = size.x as usize * size.y as usize;
        if pixels == 0 {
            return Err(QualityError::Empty { size });
        }
        if values.len() != pixels {
            return Err(QualityError::Length {
                size,
                given: values.len(),
            });
        }
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            let (x, y) = (i as u32 % size.x, i as u32 / size.x);
            return Err(QualityError::NotFinite {
                x,
                y,
                value: values[i],
            });
        }
        Ok(Self { size, values })
    }

    /// Luma of an image's 8-bit sRGB values, 0 to 255; see [`Image::to_luma`].
    ///
    /// # Errors
    /// If it has no pixels, or not one colour per pixel.
    pub fn luma(image: &Image) -> Result<Self, QualityError> {
        Self::new(image.size, image.to_luma())
    }

    /// Pixels, width × height.
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// All values, row by row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The values of row `y`.
    pub fn row(&self, y: usize) -> &[f64] {
        let width = self.size.x as usize;
        &self.values[y * width..][..width]
    }

    /// Refuses planes of different size.
    pub(crate) fn same_size(&self, other: &Self) -> Result<(), QualityError> {
        if self.size == other.size {
            Ok(())
        } else {
            Err(QualityError::SizesDiffer {
                a: self.size,
                b: other.size,
            })
        }
    }

    /// A plane whose values are finite by construction.
    pub(crate) fn from_finite(size: UVec2, values: Vec<f64>) -> Self {
        debug_assert_eq!(values.len(), size.x as usize * size.y as usize);
        Self { size, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_plane_is_refused_and_named() {
        let size = UVec2::new(3, 2);
        assert_eq!(
            Plane::new(UVec2::new(0, 5), vec![]),
            Err(QualityError::Empty {
                size: UVec2::new(0, 5)
            })
        );
        assert_eq!(
            Plane::new(size, vec![0.0; 5]),
            Err(QualityError::Length { size, given: 5 })
        );
        let error = Plane::new(size, vec![0.0, 0.0, 0.0, 0.0, f64::INFINITY, 0.0]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "pixel (1, 1) = inf: must be a finite number"
        );
    }
}
