use super::*;
use crate::specular_chain::SpecularChain;

fn plan() -> Plan {
    let row = |class| Row { group: GroupId(0), class, verdict: Verdict::Skip { because: "a test".to_owned() } };
    Plan::of(Class::ALL.map(row).to_vec(), PathMode::default())
}

/// A plan from a file may say anything.
#[test]
fn numbers_that_do_not_fit_are_refused() {
    let fault = |change: &dyn Fn(&mut Plan)| {
        let mut plan = plan();
        change(&mut plan);
        plan.check(1, 1).unwrap_err()
    };
    assert_eq!(plan().check(1, 1), Ok(()));
    assert!(plan().check(2, 1).unwrap_err().contains("4 rows for 2 groups"));
    for share in [0.0, -1.0, 1.5, f64::NAN] {
        assert!(fault(&|plan| plan.backward_share = share).contains("shares"));
        assert!(fault(&|plan| plan.unknown_share = share).contains("shares"));
        assert!(fault(&|plan| plan.vision_share = share).contains("shares"));
        assert!(fault(&|plan| plan.faintest_branch = share).contains("shares"));
    }
    assert!(fault(&|plan| plan.faintest_branch = 1e-9).contains("branches down to shares"));
    assert!(fault(&|plan| plan.backward_paths = 0).contains("0 backward paths"));
    assert!(fault(&|plan| plan.photon_radii_m.caustic = f64::INFINITY).contains("radii"));
    let connection =
        |group| Connection { group, train: SpecularChain::default(), seeds: Vec::new(), share: 1.0, reached: true };
    assert!(fault(&|plan| plan.connections = vec![connection(GroupId(1))]).contains("group 1 of 1"));
    let many = |count: usize| move |plan: &mut Plan| plan.connections = vec![connection(GroupId(0)); count];
    assert!(fault(&many(MOST_ENTRIES + 1)).contains("513 connections, more than 512"));
    let mut most = plan();
    many(MOST_ENTRIES)(&mut most);
    assert_eq!(most.check(1, 1), Ok(()));
}

/// Of vision that is connected rays from the eye have what no train is known for; of caustics photons have all that is left.
#[test]
fn what_connection_leaves_is_computed_by_those_who_have_it() {
    let mut plan = plan();
    let connect = |rest| Verdict::Connect { rest, because: "a test".to_owned() };
    for row in &mut plan.rows {
        match row.class {
            Class::Vision => row.verdict = connect(Estimator::Forward),
            Class::Caustic => row.verdict = connect(Estimator::Photon),
            Class::Primary | Class::Secondary => {}
        }
    }
    let by = |class, has_broad| Estimator::ALL.map(|estimator| plan.computes(estimator, GroupId(0), class, has_broad));
    assert_eq!(by(Class::Vision, false), [true, true, false, true]);
    assert_eq!(by(Class::Caustic, true), [false, false, true, true]);
    // At narrow lobes nothing is gathered.
    assert_eq!(by(Class::Caustic, false), [true, false, false, false]);
    plan.rows[Class::Caustic as usize].verdict = Verdict::Skip { because: "a test".to_owned() };
    assert!(plan.runs(Estimator::Backward) && !plan.owns(Estimator::Backward));
}
