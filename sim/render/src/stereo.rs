use foveasim_assets::Scene;
use foveasim_models::{Eye, Image, Pose, SamplePlan, View, Work};

use crate::check::check;
use crate::moving::Warp;
use crate::passes::{Drawn, draw_objects, objects_of};
use crate::project::Optics;
use crate::raster::ViewGeometry;
use crate::visible::PassObjects;
use crate::{Frame, FrameMemory, RenderError, RenderOptions, frame};

/// One moment as both eyes see it.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoFrame {
    /// The left eye's frame, then the right one's: each with its own work.
    pub eyes: [Frame; 2],
    /// All work, that of both eyes and what they share.
    pub work: Work,
    /// What was done once for both.
    pub shared: StereoShared,
}

/// Work that was done once and served two eyes; nothing, unless
/// [`Skip::repeated_for_eyes`](crate::Skip::repeated_for_eyes) is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StereoShared {
    /// Times that a mesh was chosen for an instance in a pass, and that instance kept or left out.
    pub choices: u64,
    /// Vertices taken from their object to the head, with their normals.
    pub vertices: u64,
}

/// Draws what both eyes of a head see, each by a plan of its own: the left eye's view and plan, then the right
/// one's.
///
/// An object has the same mesh in both eyes, the finer that either needs, so that outlines fuse; its distance
/// is that from the head. Vertices are taken to the head first and on to each eye from there, in
/// single precision twice. What is the same for both eyes is done once: which instances may be seen (by
/// what holds the views of both), their meshes, and vertices as far as the head. Sky, its mips and textures
/// are the scene's, made once and for all. With
/// [`Skip::repeated_for_eyes`](crate::Skip::repeated_for_eyes) off each eye does all of it anew, and the
/// pictures are the same, bit for bit.
///
/// # Errors
/// As [`render`](crate::render); if the views are not the left and the right eye's, or the plans have
/// different numbers of passes.
pub fn render_stereo(
    scene: &Scene,
    world_from_head: Pose,
    views: [&View; 2],
    plans: [&SamplePlan; 2],
    options: &RenderOptions,
) -> Result<StereoFrame, RenderError> {
    let eyes = views.map(|view| view.eye);
    if eyes != [Eye::Left, Eye::Right] {
        return Err(RenderError::OutOfRange {
            field: "eyes of the two views",
            value: eyes.map(Eye::name).join(" and "),
            valid: "left and right".into(),
        });
    }
    for (view, plan) in views.into_iter().zip(plans) {
        check(scene, view, plan, options)?;
        if Warp::of(scene, view, options).is_some_and(|warp| warp.scan.is_some()) {
            return Err(RenderError::Still {
                what: "both eyes at once",
                of: "rolling views that move",
                valid: "draw each eye's view by itself",
            });
        }
    }
    let passes = plans.map(|plan| plan.passes.len());
    let kinds = plans.map(|plan| {
        let of_pass = plan.passes.iter().map(|p| p.visibility);
        of_pass.collect::<Vec<_>>()
    });
    if kinds[0] != kinds[1] {
        return Err(RenderError::OutOfRange {
            field: "passes of the right eye's plan",
            value: format!("{} of `{}`", passes[1], plans[1].method),
            valid: format!("as the left eye's: {} of `{}`", passes[0], plans[0].method),
        });
    }
    let stereo = Stereo {
        scene,
        world_from_head,
        views,
        plans,
        options,
    };
    Ok(stereo.draw())
}

struct Stereo<'a> {
    scene: &'a Scene,
    world_from_head: Pose,
    views: [&'a View; 2],
    plans: [&'a SamplePlan; 2],
    options: &'a RenderOptions,
}

impl Stereo<'_> {
    fn draw(&self) -> StereoFrame {
        let together = self.options.skip.repeated_for_eyes;
        let due = vec![true; self.plans[0].passes.len()];
        let mut shared = StereoShared::default();
        // The same passes of both eyes at once; the second eye's are kept until its turn.
        let mut second: Vec<Option<PassObjects>> = Vec::new();
        let first = objects_of(self.plans[0], &due, |k| {
            let head = self.world_from_head.position;
            let [left, right] = PassObjects::of_eyes(
                self.scene,
                self.views,
                self.plans,
                k,
                head,
                self.options,
                together,
            );
            if together {
                shared.choices += self.scene.instances().len() as u64;
            }
            second.resize_with(k, || None);
            second.push(Some(right));
            left
        });
        let second = objects_of(self.plans[1], &due, |k| {
            let Some(objects) = second.get_mut(k).and_then(Option::take) else {
                unreachable!("the passes of both eyes find visibility alike")
            };
            objects
        });
        let objects = [first, second];
        let mut work = Work::default();
        let head = together.then(|| {
            let of_both = objects.iter().flatten().flatten();
            let head = self.head(&PassObjects::all(of_both));
            work += head.work;
            shared.vertices = head.vertices.len() as u64;
            head
        });
        let mut memory = FrameMemory::default();
        let [left, right] =
            [0, 1].map(|eye| self.eye(eye, &objects[eye], head.as_ref(), &mut memory));
        work += left.work;
        work += right.work;
        StereoFrame {
            eyes: [left, right],
            work,
            shared,
        }
    }

    /// Vertices as seen from the head.
    fn head(&self, named: &[(u32, u32)]) -> ViewGeometry {
        // Where they are on a display is worked out for each eye.
        let optics = Optics::new(&self.views[0].optics);
        let (pose, simd) = (self.world_from_head, self.options.simd);
        ViewGeometry::new(self.scene, pose, &optics, named, simd)
    }

    fn eye(
        &self,
        eye: usize,
        objects: &[Option<PassObjects>],
        head: Option<&ViewGeometry>,
        memory: &mut FrameMemory,
    ) -> Frame {
        let (view, plan) = (self.views[eye], self.plans[eye]);
        let optics = Optics::new(&view.optics);
        let eye_from_head = view.poses[0].inverse().then(self.world_from_head);
        let geometry = |named: &[(u32, u32)]| match head {
            Some(head) => head.seen_by(eye_from_head, &optics, Work::default()),
            None => {
                let own = self.head(named);
                own.seen_by(eye_from_head, &optics, own.work)
            }
        };
        let Drawn { passes, shared } = draw_objects(
            self.scene,
            view,
            plan,
            objects,
            &geometry,
            self.options,
            false,
            memory,
        );
        let (mut images, mut pass_work): (Vec<Image>, Vec<Work>) = (Vec::new(), Vec::new());
        for (samples, work) in passes.into_iter().flatten() {
            images.push(samples.image);
            pass_work.push(work);
        }
        frame::put_together(view, plan, images, pass_work, shared, self.options, memory)
    }
}
