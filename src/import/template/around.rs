//! What is around an optical assembly in its sidecar: sky, sun and eye.

use super::write::{Written, quoted};
use crate::Assembly;
use crate::frames::frame_rotation;
use eyebox_base::Where;

/// Sky and eye.
pub fn around(assembly: &Assembly, out: &mut Written) {
    out.line("\n# Sky ----------------------------------------------------------------------------------------------");
    out.line(
        "\n# [sky]                                 # TODO a panorama, if there is light outside; or a number, or a model",
    );
    out.line("# image = \"PANORAMA.exr\"");
    out.line("# scale_cd_m2 = 1                       # luminance of a pixel of value 1");
    out.line("# overcast_cd_m2 = 1000                 # instead; or luminance_cd_m2, or sun_sky = { elevation_deg = 40, turbidity = 3 }");
    out.line(
        "\n# [sun]                                 # TODO sun load: its image in the glass is a display's worst day",
    );
    out.line("# direction = [0, 1, 0]                 # towards the sun");
    out.line("\n# Eye ----------------------------------------------------------------------------------------------");
    let mut roots = assembly.nodes.iter().filter(|node| node.parent.is_none());
    let root = match (roots.next(), roots.next()) {
        (Some(root), None) => Some(root.path.clone()),
        (Some(_), Some(_)) | (None, _) => None,
    };
    let usable = |name: &String| frame_rotation(assembly, Some(&(name.clone(), Where::Nowhere))).is_ok();
    let frame = root.filter(usable).unwrap_or_else(|| "asset".to_owned());
    if assembly.cameras.iter().any(|camera| camera.yfov.is_some()) {
        out.line("\n[eye]                                   # position and directions are those of the asset's camera");
    } else {
        out.line("\n[eye]");
        out.todo(&format!("frame = {}", quoted(&frame)), "\"asset\", or the node in whose axes the next three stand");
        out.todo("position = [\"0 mm\", \"0 mm\", \"0 mm\"]", "where is the pupil?");
        out.todo("look = [0, 0, -1]", "where does it look?");
        out.line("up = [0, 1, 0]");
        out.line("fov_deg = 12                            # full horizontal field of view");
        out.line("resolution = [360, 180]");
        out.note("the eye's position and direction".to_owned());
    }
    out.line("pupil_diameter = \"4 mm\"");
    out.line("focus_distance = \"inf\"");
    out.line("age = 45");
}
