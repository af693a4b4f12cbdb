use super::layout::{Layout, PoseColumns, Rotation, Target};

/// The most columns that a layout uses.
pub(super) const WIDE: usize = 24;

/// The names of the columns that a layout uses, each once; places among them stand for columns.
struct Wanted {
    names: [&'static str; WIDE],
    used: usize,
}

impl Wanted {
    fn place(&mut self, name: &'static str) -> usize {
        let found = self.names[..self.used].iter().position(|n| *n == name);
        found.unwrap_or_else(|| {
            self.names[self.used] = name;
            self.used += 1;
            self.used - 1
        })
    }
}

/// An eye's columns, as places.
pub(super) struct EyePlaces {
    pub(super) coordinates: Vec<usize>,
    pub(super) valid: Option<usize>,
}

/// The head's columns, as places.
pub(super) struct PosePlaces {
    pub(super) position: Option<[usize; 3]>,
    pub(super) rotation: Vec<usize>,
    pub(super) rate: Option<[usize; 3]>,
}

/// All columns of a layout, as places among its names.
pub(super) struct Places {
    pub(super) names: [&'static str; WIDE],
    pub(super) time: usize,
    pub(super) eyes: Vec<EyePlaces>,
    pub(super) pose: Option<PosePlaces>,
    /// Coordinates, and the column that says that there is none.
    pub(super) target: Option<([usize; 2], Option<usize>)>,
    pub(super) session: Option<usize>,
    /// Of each kind of event in the layout.
    pub(super) events: Vec<usize>,
}

impl Places {
    pub(super) fn new(layout: &Layout) -> Self {
        let mut wanted = Wanted {
            names: [""; WIDE],
            used: 0,
        };
        let time = wanted.place(layout.time.column);
        let eye = |wanted: &mut Wanted, eye: &super::layout::EyeColumns| EyePlaces {
            coordinates: eye.columns.iter().map(|c| wanted.place(c)).collect(),
            valid: eye.valid.as_ref().map(|v| wanted.place(v.column)),
        };
        let eyes = layout.eyes.iter().map(|e| eye(&mut wanted, e)).collect();
        let pose = layout.pose.as_ref().map(|p| pose_places(p, &mut wanted));
        let target = layout.target.as_ref().map(|Target { columns, none }| {
            (
                columns.map(|c| wanted.place(c)),
                none.map(|(c, _)| wanted.place(c)),
            )
        });
        let session = layout.session.map(|c| wanted.place(c));
        let events = layout.events.iter().map(|(_, c)| wanted.place(c)).collect();
        Self {
            names: wanted.names,
            time,
            eyes,
            pose,
            target,
            session,
            events,
        }
    }
}

impl PosePlaces {
    /// The columns that must be there: a quaternion need not where there is an angular velocity.
    pub(super) fn needed(&self) -> Vec<usize> {
        let position = self.position.into_iter().flatten();
        match self.rate {
            Some(rate) => position.chain(rate).collect(),
            None => position.chain(self.rotation.iter().copied()).collect(),
        }
    }
}

fn pose_places(pose: &PoseColumns, wanted: &mut Wanted) -> PosePlaces {
    let (rotation, rate): (&[&'static str], _) = match &pose.rotation {
        Rotation::Quaternion(q) => (q, None),
        Rotation::UnityEuler(e) => (e, None),
        Rotation::Gyroscope {
            quaternion, rate, ..
        } => (quaternion, Some(rate)),
    };
    PosePlaces {
        position: pose.position.map(|p| p.map(|c| wanted.place(c))),
        rotation: rotation.iter().map(|c| wanted.place(c)).collect(),
        rate: rate.map(|r| r.map(|c| wanted.place(c))),
    }
}
