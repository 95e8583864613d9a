use super::*;
use eyebox_scene::ScatterTable;
use std::f64::consts::PI;

/// A file with these matrices `[incidence][leaving]` of the full basis.
fn file(blocks: &[(&str, Vec<f64>)], structure: &str) -> String {
    let columns = structure == "Columns";
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\"><Optical><Layer>\n\
         <DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure></DataDefinition>\n<WavelengthData>\n\
         <Wavelength unit=\"Integral\">Visible</Wavelength>\n"
    );
    for (direction, values) in blocks {
        let count = values.len().isqrt();
        let stored = if columns { transposed(values, count) } else { values.clone() };
        let numbers: Vec<String> = stored.iter().map(|value| format!("{value:.9}")).collect();
        out += &format!(
            "<WavelengthDataBlock><WavelengthDataDirection>{direction}</WavelengthDataDirection>\n\
             <ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Full</RowAngleBasis>\n\
             <ScatteringData>\n{}\n</ScatteringData></WavelengthDataBlock>\n",
            numbers.join(",\n")
        );
    }
    out + "</WavelengthData></Layer></Optical></WindowElement>\n"
}

fn table(text: &str, notes: &mut Vec<Note>) -> ScatterTable {
    let found = read(text, Path::new("a.xml"), notes).unwrap();
    ScatterTable::new("a.xml", &found.sides).unwrap()
}

fn full() -> Basis {
    Basis::named("LBNL/Klems Full").unwrap()
}

fn of_pairs(value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let count = full().patches();
    (0..count * count).map(|k| value(k / count, k % count)).collect()
}

/// The projected solid angles of all patches are those of a hemisphere, π; the full basis has 145 patches, the half one 73,
/// the quarter one 41 (as their names in Radiance say).
#[test]
fn bases() {
    for (name, count) in [("LBNL/Klems Full", 145), ("LBNL/Klems Half", 73), ("lbnl/klems quarter", 41)] {
        let basis = Basis::named(name).unwrap();
        assert_eq!(basis.patches(), count);
        let all: f64 = (0..basis.rings.len()).map(|ring| basis.solid_angle(ring) * basis.rings[ring].1 as f64).sum();
        assert!((all - PI).abs() < 1e-12, "{name}: {all}");
    }
    let basis = full();
    assert_eq!(
        [basis.at(0, 1.0), basis.at(1, 0.0), basis.at(1, -0.3), basis.at(1, 0.5), basis.at(2, PI)],
        [0, 1, 1, 2, 17]
    );
}

#[test]
fn a_lambertian_film() {
    let blocks = [("Reflection Front", of_pairs(|_, _| 0.3 / PI)), ("Transmission Front", of_pairs(|_, _| 0.6 / PI))];
    for structure in ["Columns", "Rows"] {
        let (text, mut notes) = (file(&blocks, structure), Vec::new());
        assert!(is_klems(&text) && notes.is_empty());
        let table = table(&text, &mut notes);
        for theta in [0.0, 0.5, 1.4] {
            let [r, t] = table.shares(theta);
            assert!((r - 0.3).abs() < 1e-6 && (t - 0.6).abs() < 1e-6, "{r} {t}");
        }
        assert_eq!(notes, []);
    }
}

/// What stays in its patch goes straight on: at the same angle, onwards, with all of its light.
#[test]
fn straight_on() {
    let basis = full();
    let ring = |patch: usize| (0..9).rev().find(|ring| basis.first(*ring) <= patch).unwrap();
    let values = of_pairs(|from, to| if from == to { 0.8 / basis.solid_angle(ring(from)) } else { 0.0 });
    let (text, mut notes) = (file(&[("Transmission Front", values)], "Columns"), Vec::new());
    let found = read(&text, Path::new("a.xml"), &mut notes).unwrap();
    assert!(found.totals[1].iter().all(|[_, total]| (total - 0.8).abs() < 1e-6), "{:?}", found.totals);
    assert_eq!(
        found.totals[1].iter().map(|[angle, _]| angle.round()).collect::<Vec<_>>()[..4],
        [0.0, 10.0, 20.0, 30.0]
    );
    let table = ScatterTable::new("a.xml", &found.sides).unwrap();
    for degrees in [2.0_f64, 10.0, 30.0, 50.0, 70.0, 80.0] {
        let theta = degrees.to_radians();
        let [r, t] = table.shares(theta);
        assert!(r == 0.0 && (t - 0.8).abs() < 0.02, "{degrees}: {t}");
        assert!(table.at(1, theta, theta, 0.0) > 1.0);
        if degrees > 5.0 {
            assert_eq!(table.at(1, theta, theta, PI), 0.0);
        }
    }
}

/// Light that is sent to one side of the sample alone is told, and so is a back unlike the front.
#[test]
fn what_is_not_alike_is_said() {
    let lopsided = of_pairs(|_, to| if (1..=4).contains(&to) { 0.9 } else { 0.0 });
    let (text, mut notes) = (file(&[("Transmission Front", lopsided)], "Columns"), Vec::new());
    read(&text, Path::new("a.xml"), &mut notes).unwrap();
    assert!(notes.len() == 1 && notes[0].text.contains("along and across"), "{notes:?}");
    let blocks = [("Reflection Front", of_pairs(|_, _| 0.1)), ("Reflection Back", of_pairs(|_, _| 0.05))];
    let (text, mut notes) = (file(&blocks, "Columns"), Vec::new());
    let found = read(&text, Path::new("a.xml"), &mut notes).unwrap();
    assert!(notes.len() == 1 && notes[0].text.contains("differs by 67 %"), "{notes:?}");
    assert!((found.totals[0][3][1] - 0.075 * PI).abs() < 1e-6);
}

#[test]
fn faults_are_lines() {
    let good = file(&[("Transmission Front", of_pairs(|_, _| 0.1))], "Columns");
    for (from, to, why) in [
        ("Columns", "TensorTree4", "a.xml:3: a tensor tree is not read"),
        ("Columns", "Boxes", "data structure `Boxes`"),
        ("LBNL/Klems Full</Col", "LBNL/Klems Fool</Col", "ColumnAngleBasis is `LBNL/Klems Fool`"),
        ("LBNL/Klems Full</Row", "LBNL/Klems Half</Row", "different angle bases"),
        ("Transmission Front", "Transmission Up", "direction `Transmission Up`"),
        ("Visible", "Solar", "nothing is measured of visible light"),
        ("0.100000000,\n", "", "the matrix has 21024 values"),
        ("0.100000000,\n", "0.1,0.1,", "value 21026 of the matrix"),
        ("0.100000000,\n", "nan,", "value 1 of the matrix, `nan`"),
        ("0.100000000,\n", "-4,", "value 1 of the matrix, `-4`"),
        ("<Layer>", "<Leyer>", "a.xml:"),
        ("</WindowElement>", "", "a.xml:"),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        let fault = read(&bad, Path::new("a.xml"), &mut Vec::new()).err().unwrap_or_else(|| panic!("{to}")).to_string();
        assert!(fault.contains(why) && !fault.contains('\n'), "{to}: {fault}");
    }
    // Cut off anywhere.
    for end in (0..good.len()).step_by(997) {
        let _ = read(&good[..end], Path::new("a.xml"), &mut Vec::new());
    }
    // Deep nests and noise.
    for bad in ["<WindowElement>".repeat(100_000), "<WindowElement>\u{0}&#1114112;</WindowElement>".to_owned()] {
        assert!(read(&bad, Path::new("a.xml"), &mut Vec::new()).is_err());
    }
    let bomb = "<!DOCTYPE a [<!ENTITY b \"bb\"><!ENTITY c \"&b;&b;\">]><WindowElement>&c;</WindowElement>";
    assert!(read(bomb, Path::new("a.xml"), &mut Vec::new()).is_err());
}

/// What colours a file tells of is said to be left out; of heat and the sun nothing is asked.
#[test]
fn colours_are_said() {
    let good = file(&[("Transmission Front", of_pairs(|_, _| 0.1))], "Columns");
    for (wavelength, count) in [("CIE-X", 1), ("NIR", 0)] {
        let more = format!("<WavelengthData><Wavelength>{wavelength}</Wavelength></WavelengthData></Layer>");
        let mut notes = Vec::new();
        read(&good.replacen("</Layer>", &more, 1), Path::new("a.xml"), &mut notes).unwrap();
        assert_eq!(notes.len(), count, "{notes:?}");
    }
}

/// A matrix that is alike all round and both ways has its own values in the middle of its patches.
#[test]
fn values_are_kept() {
    let basis = full();
    let ring = |patch: usize| (0..9).rev().find(|ring| basis.first(*ring) <= patch).unwrap();
    let value =
        |a: usize, b: usize| 0.12 * (-(a as f64 - b as f64).powi(2) / 6.0).exp() * (1.0 - 0.05 * (a + b) as f64);
    let values = of_pairs(|from, to| value(ring(from), ring(to)));
    let mut notes = Vec::new();
    let table = table(&file(&[("Reflection Front", values)], "Rows"), &mut notes);
    assert_eq!(notes, []);
    let middle = |ring: usize| {
        let [low, high] = basis.rings[ring].0;
        0.5 * (low + high)
    };
    for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
        let (got, back) = (table.at(0, middle(a), middle(b), 1.0), table.at(0, middle(b), middle(a), 1.0));
        // The file has nine digits behind the point.
        assert!((got - value(a, b)).abs() < 1e-9 && (got / back - 1.0).abs() < 1e-12, "{a} {b}: {got} {back}");
    }
}

/// A basis of the file's own, of three rings.
#[test]
fn a_basis_of_its_own() {
    let ring = |low: f64, high: f64, count: usize| {
        format!(
            "<AngleBasisBlock><Theta>0</Theta><nPhis>{count}</nPhis><ThetaBounds><LowerTheta>{low}</LowerTheta>\
             <UpperTheta>{high}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        )
    };
    let with = |rings: &str| {
        let numbers = vec!["0.2"; 11 * 11].join(" ");
        format!(
            "<WindowElement><Optical><Layer><DataDefinition><IncidentDataStructure>Rows</IncidentDataStructure><AngleBasis>\
             <AngleBasisName>mine</AngleBasisName>{rings}</AngleBasis></DataDefinition><WavelengthData>\
             <Wavelength>Visible</Wavelength><WavelengthDataBlock><WavelengthDataDirection>Reflection Back</WavelengthDataDirection>\
             <ColumnAngleBasis>mine</ColumnAngleBasis><RowAngleBasis>Mine</RowAngleBasis><ScatteringData>{numbers}</ScatteringData>\
             </WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
        )
    };
    let good = [ring(0.0, 10.0, 1), ring(10.0, 40.0, 4), ring(40.0, 90.0, 6)].concat();
    let table = table(&with(&good), &mut Vec::new());
    assert!((table.shares(0.7)[0] - 0.2 * PI).abs() < 1e-5);
    for bad in
        [ring(0.0, 10.0, 0), ring(0.0, 10.0, 11), [ring(0.0, 10.0, 1), ring(20.0, 90.0, 10)].concat(), String::new()]
    {
        assert!(read(&with(&bad), Path::new("a.xml"), &mut Vec::new()).is_err());
    }
}
