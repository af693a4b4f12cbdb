use foveasim_models::Image;
use glam::{DVec2, UVec2, Vec3};

use crate::Mask;
use crate::cells::nearest_sites;

/// The cells of a mask's sites around its middle, each in a colour of its own, with a dot at each site: `size` pixels, of
/// which `zoom` show one pixel of the mask.
pub fn cells_picture(mask: &Mask, size: UVec2, zoom: u32) -> Image {
    let zoom = zoom.max(1);
    let owner = nearest_sites(mask.size(), mask.sites());
    let mut image = Image::filled(size, [0.0; 3]);
    let origin = origin(mask, size, zoom);
    for y in 0..size.y {
        for x in 0..size.x {
            let at = (origin + UVec2::new(x, y).as_dvec2() / f64::from(zoom)).floor();
            if at.cmpge(DVec2::ZERO).all() && at.cmplt(mask.size().as_dvec2()).all() {
                let at = at.as_uvec2();
                let site = owner[(at.y * mask.size().x + at.x) as usize];
                image.rgb[(y * size.x + x) as usize] = pale(site);
            }
        }
    }
    for (k, site) in mask.sites().iter().enumerate() {
        let at = (*site - origin) * f64::from(zoom);
        let radius = (0.15 * f64::from(mask.spacing()[k]) * f64::from(zoom)).clamp(0.5, 2.5);
        dot(&mut image, at, radius, [0.0; 3]);
    }
    image
}

/// The rays of a mask around its middle in the order in which they are cast, joined by lines from blue (first) to yellow.
pub fn order_picture(mask: &Mask, size: UVec2, zoom: u32) -> Image {
    let zoom = zoom.max(1);
    let mut image = Image::filled(size, [1.0; 3]);
    let origin = origin(mask, size, zoom);
    let on_picture = |at: &DVec2| (*at - origin) * f64::from(zoom);
    let count = mask.sites().len() as f32;
    for (k, pair) in mask.sites().windows(2).enumerate() {
        let [from, to] = [on_picture(&pair[0]), on_picture(&pair[1])];
        let far = size.as_dvec2();
        let beside = |p: DVec2| p.cmplt(DVec2::ZERO).any() || p.cmpgt(far).any();
        if beside(from) && beside(to) {
            continue;
        }
        let share = k as f32 / count;
        let [blue, red, yellow] = [
            Vec3::new(0.05, 0.05, 0.6),
            Vec3::new(0.7, 0.05, 0.15),
            Vec3::new(0.85, 0.65, 0.0),
        ];
        let colour = if share < 0.5 {
            blue.lerp(red, 2.0 * share)
        } else {
            red.lerp(yellow, 2.0 * share - 1.0)
        };
        line(&mut image, from, to, colour.to_array());
    }
    image
}

/// Mask pixel of the picture's upper left corner.
fn origin(mask: &Mask, size: UVec2, zoom: u32) -> DVec2 {
    mask.size().as_dvec2() / 2.0 - size.as_dvec2() / (2.0 * f64::from(zoom))
}

/// A light colour that differs from number to number.
fn pale(number: u32) -> [f32; 3] {
    let bits = number.wrapping_mul(0x9e37_79b1);
    let part = |shift: u32| 0.35 + 0.6 * f32::from((bits >> shift) as u8) / 255.0;
    [part(24), part(16), part(8)]
}

fn dot(image: &mut Image, at: DVec2, radius: f64, colour: [f32; 3]) {
    let (low, high) = (at - radius, at + radius);
    if high.cmplt(DVec2::ZERO).any() || low.cmpge(image.size.as_dvec2()).any() {
        return;
    }
    let low = low.floor().max(DVec2::ZERO).as_uvec2();
    let high = high.ceil().max(DVec2::ZERO).as_uvec2().min(image.size);
    for y in low.y..high.y {
        for x in low.x..high.x {
            let away = UVec2::new(x, y).as_dvec2() + 0.5 - at;
            if away.length_squared() <= radius * radius {
                image.rgb[(y * image.size.x + x) as usize] = colour;
            }
        }
    }
}

fn line(image: &mut Image, from: DVec2, to: DVec2, colour: [f32; 3]) {
    let way = to - from;
    // Lines that leave the picture are followed no farther than it needs.
    let steps = way.abs().max_element().ceil().clamp(1.0, 20_000.0) as u32;
    for k in 0..=steps {
        let at = from + way * (f64::from(k) / f64::from(steps));
        if at.cmpge(DVec2::ZERO).all() && at.cmplt(image.size.as_dvec2()).all() {
            let at = at.as_uvec2();
            image.rgb[(at.y * image.size.x + at.x) as usize] = colour;
        }
    }
}
