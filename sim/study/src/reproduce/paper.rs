use std::fmt;

/// A paper that is reproduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paper {
    /// Guenter, Finch, Drucker, Tan & Snyder, *Foveated 3D Graphics*, ACM TOG 31(6), 2012.
    Guenter2012,
    /// Friston, Ritschel & Steed, *Perceptual Rasterization for Head-mounted Display Image Synthesis*, ACM TOG 38(4), 2019.
    Friston2019,
    /// Bruder, Schulz, Bauer, Frey, Weiskopf & Ertl, *Voronoi-Based Foveated Volume Rendering*, EuroVis 2019.
    Bruder2019,
    /// Meng, Du & Varshney, *Eye-dominance-guided Foveated Rendering*, IEEE TVCG 26(5), 2020.
    Meng2020,
    /// Stein et al., *A Comparison of Eye Tracking Latencies Among Several Commercial Head-Mounted Displays*,
    /// i-Perception 12, 2021.
    Stein2021,
}

impl Paper {
    /// All of them, by year.
    pub const ALL: [Self; 5] = [
        Self::Guenter2012,
        Self::Friston2019,
        Self::Bruder2019,
        Self::Meng2020,
        Self::Stein2021,
    ];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Guenter2012 => "guenter2012",
            Self::Friston2019 => "friston2019",
            Self::Bruder2019 => "bruder2019",
            Self::Meng2020 => "meng2020",
            Self::Stein2021 => "stein2021",
        }
    }

    /// First author, year and title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Guenter2012 => "Guenter et al. 2012, Foveated 3D Graphics",
            Self::Friston2019 => "Friston et al. 2019, Perceptual Rasterization",
            Self::Bruder2019 => "Bruder et al. 2019, Voronoi-Based Foveated Volume Rendering",
            Self::Meng2020 => "Meng et al. 2020, Eye-dominance-guided Foveated Rendering",
            Self::Stein2021 => "Stein et al. 2021, A Comparison of Eye Tracking Latencies",
        }
    }

    /// Whether images are drawn for it.
    pub fn is_drawn(self) -> bool {
        self != Self::Stein2021
    }
}

impl fmt::Display for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
