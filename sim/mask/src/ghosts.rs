use glam::{DVec2, UVec2};

/// Sites of a mask and their mirror images beyond its edges.
pub(crate) struct Mirrored {
    /// The sites, and after them the images.
    pub(crate) places: Vec<DVec2>,
    /// The site that each place stands for.
    pub(crate) site: Vec<u32>,
}

/// Mirrors those sites at the mask's edges that are nearest to pixels there, and at its corners those of the corners.
///
/// An image is as far from the edge as its site, so cells end at the edge, and every pixel lies within the hull of
/// all: all have weights. What an image has of them counts for its site.
pub(crate) fn mirrored(size: UVec2, sites: &[DVec2], owner: &[u32]) -> Mirrored {
    let (width, height) = (size.x as usize, size.y as usize);
    let owner_at = |x: usize, y: usize| owner[y * width + x];
    let far = size.as_dvec2();
    // Whose cells meet each edge, and twice where the edge lies, on its axis.
    let edges = [
        ((0..height).map(|y| owner_at(0, y)).collect(), 0, 0.0),
        (
            (0..height).map(|y| owner_at(width - 1, y)).collect(),
            0,
            2.0 * far.x,
        ),
        ((0..width).map(|x| owner_at(x, 0)).collect(), 1, 0.0),
        (
            (0..width).map(|x| owner_at(x, height - 1)).collect(),
            1,
            2.0 * far.y,
        ),
    ];
    let mut out = Mirrored {
        places: sites.to_vec(),
        site: (0..sites.len() as u32).collect(),
    };
    let mut add = |site: u32, at: DVec2| {
        out.places.push(at);
        out.site.push(site);
    };
    for (owners, axis, twice) in edges {
        let mut owners: Vec<u32> = owners;
        owners.sort_unstable();
        owners.dedup();
        for site in owners {
            let mut image = sites[site as usize];
            image[axis] = twice - image[axis];
            add(site, image);
        }
    }
    for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let site = owner_at(x * (width - 1), y * (height - 1));
        let at = sites[site as usize];
        let mirror = |far: f64, v: f64, end: usize| 2.0 * far * end as f64 - v;
        add(
            site,
            DVec2::new(mirror(far.x, at.x, x), mirror(far.y, at.y, y)),
        );
    }
    out
}
