use foveasim_models::{HeadPredictor, ModelError, unknown_name};

/// The predictors of a replay by name.
///
/// `linear` goes on linearly in position and angle, which for angles is constant angular velocity. What
/// [`HeadPredictor::name`] calls linear takes the components of the quaternion instead; here it is
/// `components`.
const PREDICTORS: [(&str, HeadPredictor); 7] = {
    let [constant, components, steady, accelerated, kalman, smoothed] = HeadPredictor::ALL;
    [
        ("constant", constant),
        ("linear", steady),
        ("components", components),
        ("angular-velocity", steady),
        ("acceleration", accelerated),
        ("kalman", kalman),
        ("double-exponential", smoothed),
    ]
};

/// The predictor that a replay or a scenario means by `name`, with default settings: `constant`, `linear`
/// (the same as `angular-velocity`), `components`, `angular-velocity`, `acceleration`, `kalman` or
/// `double-exponential`.
///
/// # Errors
/// If there is none of this name.
pub fn head_predictor(name: &str) -> Result<HeadPredictor, ModelError> {
    let found = PREDICTORS.iter().find(|(known, _)| *known == name);
    let error = || unknown_name("predictor", name, &PREDICTORS.map(|(known, _)| known));
    found.map(|(_, predictor)| *predictor).ok_or_else(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_and_listed() {
        for predictor in HeadPredictor::ALL {
            let name = match predictor {
                HeadPredictor::Linear => "components",
                other => other.name(),
            };
            assert_eq!(head_predictor(name), Ok(predictor));
        }
        let linear = head_predictor("linear");
        assert_eq!(linear, Ok(HeadPredictor::AngularVelocity));
        let error = head_predictor("brownian").unwrap_err().to_string();
        for (name, _) in PREDICTORS {
            assert!(error.contains(name), "{error} should list {name}");
        }
    }
}
