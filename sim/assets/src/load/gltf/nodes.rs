use std::collections::HashMap;

use foveasim_models::Pose;
use glam::{DMat3, DMat4, DQuat, DVec3};

use super::super::error::Flaw;
use super::super::soup::coordinate;
use super::super::text::shown;
use super::super::{Draft, Warnings};
use super::animation::{Animation, even, unit};
use super::container::Document;
use super::get;
use super::json::{Node, Root};
use super::materials::Materials;
use super::primitives::Primitives;
use crate::{Instance, Motion, Similarity, Track};

/// Most moving frames within one another.
const MOST_MOVING: usize = 64;
/// Most instances: as many as a scene can tell apart.
const MOST_INSTANCES: usize = 1 << 19;

/// Where a node is within its parent when nothing moves.
pub(super) struct Rest {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

/// A node's frame in the world: frames that move, then what does not move within the last of them.
#[derive(Clone, Default)]
struct Frame {
    chain: Vec<Track>,
    tail: DMat4,
}

/// Walks through the nodes and places their meshes.
pub(super) struct Placer<'a, 'b> {
    document: &'a Document<'a>,
    materials: &'b Materials,
    animation: Animation,
    primitives: Primitives<'a>,
    draft: &'b mut Draft,
    warnings: &'b mut Warnings,
    /// Meshes as the file has them, by mesh and primitive; none where nothing is drawn.
    meshes: HashMap<(usize, usize), Option<usize>>,
    /// Nodes that have been placed.
    seen: Vec<bool>,
}

impl<'a, 'b> Placer<'a, 'b> {
    pub(super) fn new(
        document: &'a Document<'a>,
        materials: &'b Materials,
        animation: Animation,
        draft: &'b mut Draft,
        warnings: &'b mut Warnings,
    ) -> Self {
        Self {
            document,
            materials,
            animation,
            primitives: Primitives::new(document),
            draft,
            warnings,
            meshes: HashMap::new(),
            seen: vec![false; document.root.nodes.len()],
        }
    }

    /// Adds instances, meshes and motions of the scene to the draft.
    pub(super) fn place_all(&mut self) -> Result<(), Flaw> {
        let root = &self.document.root;
        // In the order of the file: the last one pushed comes first.
        let mut stack: Vec<(usize, Frame)> = roots(root)?
            .into_iter()
            .rev()
            .map(|node| (node, Frame::default()))
            .collect();
        while let Some((index, parent)) = stack.pop() {
            let node = get(&root.nodes, index, "node", "scene")?;
            let place = match &node.name {
                Some(name) => format!("nodes[{index}] {}", shown(name)),
                None => format!("nodes[{index}]"),
            };
            if std::mem::replace(&mut self.seen[index], true) {
                let problem = "is reached twice: nodes must form a tree";
                return Err(Flaw::new(place, problem));
            }
            let frame = self.frame(index, node, parent, &place)?;
            if let Some(mesh) = node.mesh {
                if node.skin.is_some() {
                    self.warnings
                        .add("skins are not applied: meshes stay as they are at rest");
                }
                self.place(mesh, &frame, &place)?;
            }
            for &child in node.children.iter().rev() {
                get(&root.nodes, child, "node", &place)?;
                stack.push((child, frame.clone()));
            }
        }
        Ok(())
    }

    /// The frame of a node whose parent's is given.
    fn frame(
        &self,
        index: usize,
        node: &Node,
        mut frame: Frame,
        place: &str,
    ) -> Result<Frame, Flaw> {
        if !self.animation.moves(index) {
            frame.tail *= local(node, place)?;
            return Ok(frame);
        }
        if node.matrix.is_some() {
            let problem = "moves and has a matrix: must have translation, rotation and scale";
            return Err(Flaw::new(place, problem));
        }
        if frame.tail != DMat4::IDENTITY {
            let Some(still) = similarity(&frame.tail) else {
                let problem = "moves within a frame that is mirrored or unevenly scaled, so that \
                               its movement is not rigid";
                return Err(Flaw::new(place, problem));
            };
            frame.chain.push(self.still(still, place)?);
            frame.tail = DMat4::IDENTITY;
        }
        let rest = Rest::of(node, place)?;
        let is_even = even(rest.scale);
        let scale = if is_even { rest.scale.x } else { 1.0 };
        let track = self.animation.track(index, &rest, scale, place)?;
        frame.chain.push(track);
        // What is uneven but does not change belongs to the mesh.
        if !is_even && !self.animation.scales(index) {
            frame.tail = DMat4::from_scale(rest.scale);
        }
        if frame.chain.len() > MOST_MOVING {
            let problem = format!("moves within more than {MOST_MOVING} others");
            return Err(Flaw::new(place, problem));
        }
        Ok(frame)
    }

    fn still(&self, placement: Similarity, place: &str) -> Result<Track, Flaw> {
        Track::still(placement).map_err(|e| Flaw::new(place, e))
    }

    /// Adds the primitives of mesh `index` at `frame`.
    fn place(&mut self, index: usize, frame: &Frame, place: &str) -> Result<(), Flaw> {
        let mesh = get(&self.document.root.meshes, index, "mesh", place)?;
        let placement = similarity(&frame.tail);
        for (k, primitive) in mesh.primitives.iter().enumerate() {
            let at = format!("meshes[{index}].primitives[{k}]");
            let (material, info) = self.materials.of(primitive.material, &at)?;
            let known = self.meshes.get(&(index, k)).copied();
            let drawn = match (placement, known) {
                (Some(_), Some(known)) => known,
                _ => {
                    let baked = if placement.is_some() {
                        DMat4::IDENTITY
                    } else {
                        frame.tail
                    };
                    let read =
                        self.primitives
                            .read(primitive, info.uv_set, baked, &at, self.warnings)?;
                    let drawn = read.map(|mesh| {
                        self.draft.meshes.push(mesh);
                        self.draft.meshes.len() - 1
                    });
                    if placement.is_some() {
                        self.meshes.insert((index, k), drawn);
                    }
                    drawn
                }
            };
            let Some(drawn) = drawn else { continue };
            let uv = format!("TEXCOORD_{}", info.uv_set);
            self.draft.has_uvs |= primitive.attributes.contains_key(&uv);
            let mut world_from_object = placement.unwrap_or(Similarity::IDENTITY);
            if !frame.chain.is_empty() {
                let mut chain = frame.chain.clone();
                if world_from_object != Similarity::IDENTITY {
                    chain.push(self.still(world_from_object, place)?);
                }
                // Placed by the motion from now on.
                world_from_object = Similarity::IDENTITY;
                self.draft.motions.push(Motion {
                    instance: self.draft.instances.len(),
                    chain,
                });
            }
            self.draft.instances.push(Instance {
                lod: None,
                mesh: drawn,
                material,
                world_from_object,
                two_sided: info.two_sided,
            });
            if self.draft.instances.len() > MOST_INSTANCES {
                let problem = format!("more than {MOST_INSTANCES} primitives in all places");
                return Err(Flaw::new(place, problem));
            }
        }
        Ok(())
    }
}

impl Rest {
    fn of(node: &Node, place: &str) -> Result<Self, Flaw> {
        let vector = |values: Option<[f64; 3]>, default: DVec3, what: &str| {
            let values = values.unwrap_or(default.to_array());
            for v in values {
                coordinate(v, what).map_err(|p| Flaw::new(place, p))?;
            }
            Ok::<_, Flaw>(DVec3::from_array(values))
        };
        let q = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let Some(rotation) = unit(q) else {
            let problem = format!("rotation {q:?}: must be a quaternion of length 1");
            return Err(Flaw::new(place, problem));
        };
        Ok(Self {
            translation: vector(node.translation, DVec3::ZERO, "translation")?,
            rotation,
            scale: vector(node.scale, DVec3::ONE, "scale")?,
        })
    }
}

/// Nodes to begin with: of the scene that the file names, or of its first, or without any scene all
/// that are nobody's children.
fn roots(root: &Root) -> Result<Vec<usize>, Flaw> {
    if root.scene.is_none() && root.scenes.is_empty() {
        let mut is_child = vec![false; root.nodes.len()];
        for &child in root.nodes.iter().flat_map(|n| &n.children) {
            if let Some(flag) = is_child.get_mut(child) {
                *flag = true;
            }
        }
        let free = (0..root.nodes.len()).filter(|&i| !is_child[i]);
        return Ok(free.collect());
    }
    let scene = get(&root.scenes, root.scene.unwrap_or(0), "scene", "scene")?;
    Ok(scene.nodes.clone())
}

/// Parent from node coordinates.
fn local(node: &Node, place: &str) -> Result<DMat4, Flaw> {
    let Some(columns) = node.matrix else {
        let rest = Rest::of(node, place)?;
        return Ok(DMat4::from_scale_rotation_translation(
            rest.scale,
            rest.rotation,
            rest.translation,
        ));
    };
    let matrix = DMat4::from_cols_array(&columns);
    let affine = matrix.row(3) == glam::DVec4::W;
    if !(affine && columns.iter().all(|v| v.abs() <= 1e6)) {
        let problem = format!("matrix {columns:?}: must be affine, with numbers within ±1e6");
        return Err(Flaw::new(place, problem));
    }
    Ok(matrix)
}

/// `matrix` as rotation, even scale and translation, if it is that to single precision.
fn similarity(matrix: &DMat4) -> Option<Similarity> {
    const CLOSE: f64 = 1e-5;
    let m = DMat3::from_mat4(*matrix);
    let lengths = DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length());
    if !even(lengths) {
        return None;
    }
    let [x, y, z] = [
        m.x_axis / lengths.x,
        m.y_axis / lengths.y,
        m.z_axis / lengths.z,
    ];
    let skew = [x.dot(y), y.dot(z), z.dot(x)];
    if skew.iter().any(|s| s.abs() > CLOSE) || m.determinant() <= 0.0 {
        return None;
    }
    let orientation = DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize();
    Some(Similarity {
        pose: Pose::new(matrix.w_axis.truncate(), orientation),
        scale: (lengths.x + lengths.y + lengths.z) / 3.0,
    })
}
