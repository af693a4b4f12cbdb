use std::cell::RefCell;
use std::rc::Rc;

use glam::{DVec3, UVec2};

use super::need::Sight;
use super::{Aim, Estimate, LayerDesign, LayersSettings, Method, Request, Screen};
use crate::{Acuity, GazeDirection, ModelError, SamplePlan};

/// Keeps what estimates and plans have in common: how far the cells of a screen are from the gaze and how
/// pixels shrink there, which is the same for every acuity line, margin and method with such cells; and the radii of
/// layers, which an estimate and a plan share. Answers are those of [`Method::estimate`] and [`Method::plan`],
/// bit for bit.
///
/// It holds the last few screens and designs only: sweeps should go through one display after the other.
#[derive(Debug, Default)]
pub struct PlanCache {
    sights: Recent<SightKey, Rc<Sights>>,
    designs: Recent<DesignKey, LayerDesign>,
}

/// Screens, gazes and cells that are kept: two eyes, tracked and fixed, with cells of tiles and of bands.
const SIGHTS_KEPT: usize = 8;

/// Designs that are kept: a few counts of layers, tracked and fixed.
const DESIGNS_KEPT: usize = 8;

#[derive(Debug, PartialEq)]
struct SightKey {
    screen: Screen,
    gaze: DVec3,
    cell: UVec2,
}

#[derive(Debug, PartialEq)]
struct DesignKey {
    settings: LayersSettings,
    screen: Screen,
    acuity: Acuity,
    margin_deg: f64,
}

/// What all cells of a screen, and all blocks of cells, look like from an eye, row by row.
#[derive(Debug)]
pub(super) struct Sights {
    pub(super) cells: Vec<Sight>,
    pub(super) blocks: Vec<Sight>,
}

impl PlanCache {
    /// As [`Method::estimate`].
    ///
    /// # Errors
    /// As [`Method::estimate`].
    pub fn estimate(
        &self,
        method: &Method,
        screen: &Screen,
        acuity: Acuity,
        gaze: GazeDirection,
        margin_deg: f64,
    ) -> Result<Estimate, ModelError> {
        method.estimate_from(Some(self), screen, acuity, gaze, margin_deg)
    }

    /// As [`Method::plan`].
    ///
    /// # Errors
    /// As [`Method::plan`].
    pub fn plan(&self, method: &Method, request: &Request) -> Result<SamplePlan, ModelError> {
        let prepared = method.prepare_from(Some(self), request)?;
        prepared.plan_from(Some(self), request.gaze)
    }

    /// What cells of a screen look like: as kept, or as `make` says.
    pub(super) fn sights(
        &self,
        screen: &Screen,
        gaze: DVec3,
        cell: UVec2,
        make: impl FnOnce() -> Sights,
    ) -> Rc<Sights> {
        let key = SightKey {
            screen: *screen,
            gaze,
            cell,
        };
        let sights = self.sights.get(SIGHTS_KEPT, key, || Ok(Rc::new(make())));
        sights.unwrap_or_else(|never: std::convert::Infallible| match never {})
    }

    /// As [`LayersSettings::design`].
    pub(super) fn design(
        &self,
        settings: &LayersSettings,
        screen: &Screen,
        acuity: Acuity,
        margin_deg: f64,
    ) -> Result<LayerDesign, ModelError> {
        // Where it is aimed moves layers and does not change them.
        let settings = LayersSettings {
            aim: Aim::Tracked,
            ..*settings
        };
        let key = DesignKey {
            settings,
            screen: *screen,
            acuity,
            margin_deg,
        };
        let make = || settings.design(screen, acuity, margin_deg);
        self.designs.get(DESIGNS_KEPT, key, make)
    }
}

/// What was asked for last.
#[derive(Debug)]
struct Recent<K, V>(RefCell<Vec<(K, V)>>);

impl<K, V> Default for Recent<K, V> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    /// The value of `key`, made if it is not among the last `kept`.
    fn get<E>(&self, kept: usize, key: K, make: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        let mut all = self.0.borrow_mut();
        if let Some(at) = all.iter().position(|(k, _)| *k == key) {
            let found = all.remove(at);
            let value = found.1.clone();
            all.push(found);
            return Ok(value);
        }
        let value = make()?;
        if all.len() == kept {
            all.remove(0);
        }
        all.push((key, value.clone()));
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;

    /// From a cache that many others have used, in an order that lets entries come and go.
    #[test]
    fn answers_are_those_without_it() {
        let cache = PlanCache::default();
        let methods = "full,layers:2,layers:3:strict,layers:3:fixed,vrs,vrs:tile=8:max=2,fdm:fixed,fdm,\
                       rates,rates:bands=7,quad:auto,kfr:2:4,lms:1:1";
        let methods = Method::parse_list(methods).unwrap();
        let displays = ["lg-w2363d", "quest-pro", "dk2"].map(|d| presets::display(d).unwrap());
        for (turn, slope) in [(0.0, 0.0275), (11.0, 0.0275), (0.0, 0.022)] {
            for panel in displays.iter().flat_map(|d| &d.eyes) {
                for margin_deg in [0.0, 1.5] {
                    let request = Request {
                        acuity: Acuity::new(slope).unwrap(),
                        gaze: GazeDirection::new(turn, 3.0),
                        margin_deg,
                        ..Request::ahead(panel)
                    };
                    let screen = Screen::from(&panel.viewport);
                    let Request { acuity, gaze, .. } = request;
                    for method in &methods {
                        let [cached, plain] = [Some(&cache), None]
                            .map(|c| method.estimate_from(c, &screen, acuity, gaze, margin_deg));
                        assert_eq!(cached, plain, "{method}");
                        assert_eq!(cache.plan(method, &request), method.plan(&request));
                    }
                }
            }
        }
        assert!(cache.sights.0.borrow().len() == SIGHTS_KEPT);
        assert!(cache.designs.0.borrow().len() == DESIGNS_KEPT);
        let bad = cache.estimate(
            &methods[1],
            &Screen::planar(9.0, 1.0, 1.0).unwrap(),
            Acuity::default(),
            GazeDirection::new(0.0, 0.0),
            91.0,
        );
        assert!(bad.is_err());
    }
}
