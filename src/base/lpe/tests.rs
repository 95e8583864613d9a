use super::*;
use Verdict::{All, Impossible, Nothing};

fn everything() -> Alphabet {
    let events = Letter::ALL[1..8].to_vec();
    Alphabet { events, sources: vec![Source::Face, Source::Light, Source::Sky] }
}

fn takes(text: &str, alphabet: &Alphabet) -> [Verdict; 4] {
    let lpe = Lpe::parse(text).unwrap_or_else(|fault| panic!("{text} {fault}"));
    lpe.takes(alphabet, "led").unwrap_or_else(|fault| panic!("{text} {fault}"))
}

/// The table of `docs/layers.md`: each expression takes its class and nothing of the others.
#[test]
fn the_documented_expressions_are_the_classes() {
    let expressions = [
        "C<.[Ss]>*[LOB]",
        "C<.[Ss]>*<.[DG]>[LOB]",
        "C<.[Ss]>*<.[DG]><.[Ss]>+[LOB]",
        "C<.[Ss]>*<.[DG]>.*<.[DG]>.*[LOB]",
    ];
    for (index, text) in expressions.iter().enumerate() {
        let mut want = [Nothing, Nothing, Nothing, Nothing];
        want[index] = All;
        assert_eq!(takes(text, &everything()), want, "{text}");
        assert_eq!(takes(&format!("E{}", &text[1..]), &everything()), want);
    }
    assert_eq!(takes("C.*", &everything()), [All, All, All, All]);
    assert_eq!(takes(&expressions.join(" | "), &everything()), [All, All, All, All]);
    assert_eq!(takes("C[Ss]*[DG]?L", &everything()), [All, All, Nothing, Nothing]);
}

#[test]
fn labels_sources_and_what_a_scene_cannot_do() {
    let some = |verdict: &Verdict| matches!(verdict, Verdict::Some { .. });
    let led = Lpe::parse("C.*<L.'led'>").unwrap();
    assert_eq!(led.takes(&everything(), "led"), Ok([All, All, All, All]));
    assert_eq!(led.takes(&everything(), "sun"), Ok([Nothing, Nothing, Nothing, Nothing]));
    let others = Lpe::parse("C.*[^'led']").unwrap();
    assert_eq!(others.takes(&everything(), "led"), Ok([Nothing, Nothing, Nothing, Nothing]));
    assert_eq!(others.takes(&everything(), "sun"), Ok([All, All, All, All]));
    assert!(led.names("led") && others.names("led") && !led.names("sun"));
    let only = |source: Source| Alphabet { sources: vec![source], ..everything() };
    for (text, [face, light, sky]) in [("C.*O", [1, 0, 0]), ("C.*L", [1, 1, 1]), ("C.*B", [0, 0, 1])] {
        for (source, want) in [(Source::Face, face), (Source::Light, light), (Source::Sky, sky)] {
            let want = if want == 1 { All } else { Nothing };
            assert_eq!(
                takes(text, &only(source)),
                [want.clone(), want.clone(), want.clone(), want],
                "{text} {source:?}"
            );
        }
    }
    // Of scatterers that only reflect, `<RD>` is all.
    let [vision, primary, caustic, secondary] = takes("C<RD>L", &everything());
    assert!(vision == Nothing && some(&primary) && caustic == Nothing && secondary == Nothing);
    let Verdict::Some { takes: taken, leaves } = primary else { panic!() };
    assert_eq!((taken.as_str(), leaves.as_str()), ("C<RD>O", "C<RG>O"));
    let wall = Alphabet { events: vec![Letter::ReflectDiffuse], sources: vec![Source::Light] };
    assert_eq!(takes("C<RD>L", &wall), [Nothing, All, Impossible, Nothing]);
}

/// Against the `regex` crate on every path of up to five events.
#[test]
fn agrees_with_regular_expressions_on_every_short_path() {
    // C, then per event: a RS, b RG, c RD, d TS, e Ts, f TG, g TD; O, L and B at the end.
    let pairs = [
        ("C<.[Ss]>*<.[DG]>[LOB]", "^C[ade]*[bcfg][OLB]$"),
        ("CR*T?L", "^C[abc]*[defg]?[OLB]$"),
        ("C(<RS>|<T.>){1,2}[^D]*B", "^C([a]|[defg]){1,2}[Cabdef OLB]*B$"),
        ("C<T[^Ss]>+(O|L)", "^C[fg]+[OLB]$"),
        ("CD{2}.*", "^C[cg]{2}.*$"),
        ("C[DG]{2,}.L|C<.S>O", "^(C[bcfg]{2,}.[OLB]|C[ad]O)$"),
        ("C(S|DS)*D?[LOB]", "^C([ad]|[cg][ad])*[cg]?[OLB]$"),
    ];
    let alphabet = everything();
    for (text, pattern) in pairs {
        let pattern = regex::Regex::new(pattern).unwrap();
        let mut seen = [[false; 2]; 4];
        for length in 0..=5u32 {
            for code in 0..7usize.pow(length) {
                let events: Vec<usize> = (0..length).map(|i| code / 7usize.pow(i) % 7).collect();
                let class = events.iter().fold(crate::path::Trail::START, |trail, event| {
                    use crate::path::Event::*;
                    trail.then([Specular, Glossy, Diffuse, Specular, Specular, Glossy, Diffuse][*event])
                });
                let middle: String = events.iter().map(|event| char::from(b'a' + *event as u8)).collect();
                for source in ["O", "L", "B"] {
                    let taken = pattern.is_match(&format!("C{middle}{source}"));
                    seen[class.class_from_eye() as usize][usize::from(!taken)] = true;
                }
            }
        }
        for (class, verdict) in takes(text, &alphabet).into_iter().enumerate() {
            let got = match verdict {
                Impossible => [false, false],
                Nothing => [false, true],
                All => [true, false],
                Verdict::Some { .. } => [true, true],
            };
            assert_eq!(got, seen[class], "{text}: class {class}");
        }
    }
}

#[test]
fn faults_say_where() {
    for (text, want) in [
        ("", "is empty"),
        ("C(L", "`)` is missing, at its end"),
        ("CL)", "`)` closes nothing, at byte 2"),
        ("C<RX>L", "`X` is no event; there are C R T L O B V, S s G D, . and 'light group', at byte 3"),
        ("C<.'led>", "a label has no closing quote, at its end"),
        ("C[DL", "`]` is missing, at its end"),
        ("CD{3,2}L", "repeats at least more often than at most, at byte 7"),
        ("CD{900}L", "a number from 0 to 64 is missing, at byte 6"),
        ("C<>L", "`<>` says nothing, at byte 3"),
        ("*", "`*` is no event"),
    ] {
        let fault = Lpe::parse(text).unwrap_err();
        assert!(fault.contains(want), "{text}: {fault}");
    }
    assert!(Lpe::parse(&"(".repeat(3000)).unwrap_err().contains("inside each other"));
    assert!(Lpe::parse(&"C".repeat(5000)).unwrap_err().contains("longer"));
    assert!(Lpe::parse(&format!("C{}", "*".repeat(3000))).unwrap_err().contains("follow each other"));
    let wide = Lpe::parse("C((((.{64}){64}){64}){64})L").unwrap();
    assert!(wide.takes(&everything(), "").unwrap_err().contains("states"));
    let deep = Lpe::parse("C.*D.{40}L").unwrap();
    assert!(deep.takes(&everything(), "").unwrap_err().contains("cases"));
}

/// Any text is an expression or a fault.
#[test]
fn random_texts_end() {
    let mut state = 1u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let letters: Vec<char> = "CRTLOBSsGD.<>[]^'(){}|*+?,123 é".chars().collect();
    let mut sound = 0;
    for _ in 0..20_000 {
        let text: String = (0..next(14)).map(|_| letters[next(letters.len())]).collect();
        if let Ok(lpe) = Lpe::parse(&text) {
            sound += 1;
            drop(lpe.takes(&everything(), "1"));
        }
    }
    assert!(sound > 500, "{sound}");
}
