use foveasim_models::foveation::Request;
use foveasim_models::{Display, EyePanel};
use foveasim_reports::{ERROR_FULL_SCALE, error_map, png};
use foveasim_study::StereoStudy;

use super::{Args, pictures, viewport};
use crate::cli::{Context, Failure, options};

/// Draws both eyes of a headset. `--gaze` is where the left eye looks, in its image; the right one looks in
/// the same direction, or at the same point if that is not far away.
pub(super) fn run(args: &Args, display: &Display, ctx: &Context) -> Result<(), Failure> {
    let refuse = |text: String| Err(Failure::bad_input(text));
    let [left, right] = display.eyes.as_slice() else {
        return refuse(format!(
            "--stereo: {} is seen by both eyes as by one; want a headset, as quest-pro",
            args.display
        ));
    };
    if args.drawing.frames != 1 {
        return refuse("--stereo: draws one frame; leave --frames out".into());
    }
    let panels = [left.clone(), right.clone()];
    let requests = requests(args, display, &panels)?;
    args.drawing.check()?;
    let period_s = display.scan.rate.period().as_secs();
    let stage = args
        .scene
        .stage(&requests[0].viewport, 1, [period_s, 0.0], ctx)?;
    // Fails now, not after the work, if there is nowhere to write.
    let mut outputs = ctx.outputs("out")?;
    let mut drawing = args.drawing.drawing(stage.near_m);
    drawing.options.keep_passes = args.passes;
    args.rolling.apply(&mut drawing, panels[0].lens);
    let study = StereoStudy {
        sight: stage
            .sights(|_| None)
            .pop()
            .expect("at least one frame is drawn"),
        panels,
        requests,
        drawing,
    };
    let bar = ctx.progress(1, "drawing");
    let outcome = study.run(args.method)?;
    bar.finish_and_clear();

    for (name, eye) in ["left", "right"].into_iter().zip(&outcome.eyes) {
        let (frame, reference) = (&eye.shots[0].frame, &eye.reference.image);
        let error = error_map(&frame.image, reference, ERROR_FULL_SCALE)?;
        outputs.add(format!("{name}.png"), png(&frame.image)?);
        outputs.add(format!("{name}-reference.png"), png(reference)?);
        outputs.add(format!("{name}-error.png"), png(&error.image)?);
        for (k, pass) in pictures(frame) {
            outputs.add(format!("{name}-pass-{k}.png"), png(pass)?);
        }
    }
    let quality = outcome.quality_table();
    outputs.add("work.csv", outcome.work_table().csv());
    outputs.add("quality.csv", quality.csv());
    let dir = outputs.dir().display().to_string();
    outputs.commit()?;
    ctx.print_table(&quality)?;
    let counts = [0, 1].map(|k| outcome.eyes[k].shots[0].plan.count());
    let shared = outcome.frame.shared;
    ctx.note(&format!(
        "{}: {} and {} shaded samples for 2 x {} pixels; {} vertices and {} choices of objects served both eyes; files in {dir}",
        args.method,
        counts[0].shadings(),
        counts[1].shadings(),
        counts[0].display_pixels,
        shared.vertices,
        shared.choices,
    ));
    Ok(())
}

/// What the method plans each eye's image for.
fn requests(
    args: &Args,
    display: &Display,
    panels: &[EyePanel; 2],
) -> Result<[Request; 2], Failure> {
    let [left, right] = panels;
    let planes = [
        viewport(args, left, display)?,
        viewport(args, right, display)?,
    ];
    let gaze = args
        .gaze
        .map_or(left.ahead(), |px| planes[0].gaze_at(px.into()));
    // Where the left eye looks, as the head has it.
    let in_head = left.head_from_eye.direction(gaze.vector());
    let gazes = match args.gaze_distance {
        None => [
            gaze,
            right.in_eye(foveasim_models::GazeDirection::from_vector(in_head)),
        ],
        Some(distance) if (0.05..=1e4).contains(&distance) => {
            let point = left.head_from_eye.position + in_head * distance;
            [gaze, right.looking_at(point)]
        }
        Some(distance) => {
            return Err(Failure::bad_input(format!(
                "--gaze-distance {distance}: must be from 0.05 to 10000 m"
            )));
        }
    };
    let acuity = options::acuity(&args.slope)?;
    let request = |k: usize| Request {
        viewport: planes[k],
        acuity,
        gaze: gazes[k],
        margin_deg: args.margin,
        ..Request::ahead(&panels[k])
    };
    Ok([request(0), request(1)])
}
