//! Vertex normals contradict their triangles.

use crate::finding::Level;
use crate::rule::{Example, Rule, nothing};
use crate::subject::{Subject, is_mesh, is_specular};
use eyebox_base::Where;
use eyebox_scene::Note;

pub const RULE: Rule = Rule {
    code: "EB0108",
    name: "normals-contradict",
    level: Level::Warning,
    title: "Vertex normals contradict their triangles",
    why: "Exporters get the normals at the poles of revolved faces wrong; one of them among thousands sends light into a ghost. eyebox repairs them, other programs don't. On a face with an exact shape normals are not used, and the finding is a note.",
    bad: Example::Words("A pole whose normal points into the lens."),
    good: Example::Words("Normals of the surface, or none."),
    find: nothing,
    grade,
};

/// A face with an exact shape has the shape's normals; a face that doesn't bend light into a picture needs none.
fn grade(rule: &Rule, subject: &Subject<'_>, note: &Note) -> Level {
    let holds = |at: &Where, mesh: &Where| match (at, mesh) {
        (Where::Pointer { file: a, pointer }, Where::Pointer { file: b, pointer: of }) => {
            a == b && pointer.strip_prefix(of.as_str()).is_some_and(|rest| rest.starts_with("/primitives/"))
        }
        (at, mesh) => at == mesh,
    };
    let mesh = subject.assembly.meshes.iter().position(|mesh| holds(&note.at, &mesh.at));
    let (Some(mesh), Some(number)) = (mesh, note.face) else { return rule.level };
    let parts = subject.scene.parts.iter().filter(|part| part.mesh.index() == mesh);
    let mut faces = parts.filter_map(|part| part.faces.get(number));
    if faces.all(|face| !is_mesh(face) || !is_specular(face)) { Level::Note } else { rule.level }
}
