//! The sidecar of an asset of which no name says that it is optics: it looks as its materials say, from where and under what
//! is assumed of it. What is written changes nothing of that picture, so that it can be changed line by line.

use super::kinds::Kind;
use super::write::{Head, Written, clean, listed, quoted};
use crate::Assembly;
use crate::build::Assumed;
use eyebox_scene::Eye;
use glam::{DMat3, DVec3};

/// `assumed` of the asset without a sidecar, whose `eye` in the scene's world is the one that frames it.
pub fn write(assembly: &Assembly, kinds: &[Kind], head: &Head<'_>, assumed: Assumed, eye: &Eye) -> Written {
    let mut out = Written::default();
    top(assembly, head, &mut out);
    kinds.iter().for_each(|kind| listed(kind, &mut out));
    out.line(
        "\n# Sky ----------------------------------------------------------------------------------------------\n",
    );
    if assumed.sky {
        out.line(
            "[sky]                                   # assumed, since the asset has no light: overcast, brighter above",
        );
        out.line(&format!(
            "{:<39} # of the uniform sky that lights a floor as much",
            format!("overcast_cd_m2 = {}", assumed.sky_cd_m2)
        ));
        out.line("ground_reflectance = 0.2");
        out.line("# luminance_cd_m2 = 1000                # instead: the same from everywhere");
        out.line("# sun_sky = { elevation_deg = 40, azimuth_deg = 60, turbidity = 3 }  # instead: clear, with a sun");
    } else {
        out.line("# [sky]                                 # the asset has light of its own");
        out.line("# overcast_cd_m2 = 1000");
    }
    out.line("# image = \"PANORAMA.exr\"                # instead: a latitude-longitude panorama");
    out.line(
        "\n# Eye ----------------------------------------------------------------------------------------------\n",
    );
    if assumed.eye {
        framed(&assembly.axes, eye, &mut out);
    } else {
        out.line("# [eye]                                 # the asset has a camera; what is said here takes its place");
        out.line("# resolution = [960, 540]");
    }
    out
}

fn top(assembly: &Assembly, head: &Head<'_>, out: &mut Written) {
    let sidecar = head.sidecar.file_name().map_or_else(|| "SIDECAR".into(), |name| name.to_string_lossy());
    out.line(&format!("# Optical attributes of {}, begun by `eyebox init`.", clean(head.asset)));
    out.line("# Parts look as their materials say; no name says that one is optics. Once something below binds a part or there");
    out.line("# is a [default], materials count where nothing is bound, and the picture is 360 x 180 from a pupil of 4 mm where");
    out.line("# [eye] does not say otherwise.");
    out.line(&format!("#   eyebox inspect {}", clean(&sidecar)));
    out.line("\nschema = 1");
    out.line(&format!("asset = {}", quoted(head.asset)));
    if head.millimetres {
        // Said, it would move the lamps that the asset may have.
        out.todo(
            &format!("# unit = {}", head.unit_m),
            "taken as metres, the asset is too large for a display: millimetres?",
        );
        out.note(format!("check unit = {}: the asset looks like millimetres", head.unit_m));
    } else {
        out.line(&format!("# unit = {}  # metres per unit, as the asset declares", assembly.unit_m));
    }
    out.line("# wavelengths = { mono_nm = 550 }       # one wavelength instead of the visible range");
    out.line("\n# [[bind]]                              # a part that is more than it looks");
    out.line("# path = \"NAME\"");
    out.line("# glass = \"N-BK7\"");
    out.line("# finish = \"polished\"");
}

/// The eye in the asset's own axes: every digit, so that it is the same eye.
fn framed(axes: &DMat3, eye: &Eye, out: &mut Written) {
    let own = |v: DVec3| (axes.transpose() * v).to_array();
    let [x, y, z] = own(eye.position);
    let direction = |v: DVec3| {
        let [x, y, z] = own(v);
        format!("[{x}, {y}, {z}]")
    };
    out.line(
        "[eye]                                   # assumed, since the asset has no camera: a pinhole that frames it",
    );
    out.line("frame = \"asset\"");
    out.line(&format!("position = [\"{x} m\", \"{y} m\", \"{z} m\"]"));
    out.line(&format!("look = {}", direction(eye.look)));
    out.line(&format!("up = {}", direction(eye.up)));
    out.line(&format!("fov_deg = {:<29} # full horizontal field of view", eye.fov_deg));
    out.line(&format!("resolution = [{}, {}]", eye.resolution[0], eye.resolution[1]));
    out.line(&format!(
        "{:<39} # a pinhole; 4 mm is an eye's",
        format!("pupil_diameter = \"{} m\"", eye.pupil_diameter_m)
    ));
    out.line("focus_distance = \"inf\"");
    out.line(&format!("age = {}", eye.age));
}
