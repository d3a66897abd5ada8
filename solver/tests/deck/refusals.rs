//! Decks that are miswritten.

use super::*;

#[test]
fn misspelt_fields_name_the_nearest() {
    refused(
        "poisson = 0.3",
        "poison = 0.3",
        "deck, line 6: [materials.steel] has no field \"poison\" (did you mean \"poisson\"?); it has young, poisson, model, yield_stress, hardening",
    );
    refused("title =", "tilte =", "line 2: the deck has no field \"tilte\" (did you mean \"title\"?)");
    refused("[time]", "[tiem]", "the deck has no table \"tiem\" (did you mean \"time\"?)");
    refused("[[pressure]]", "[[presure]]", "the deck has no table \"presure\" (did you mean \"pressure\"?)");
    refused(
        "divisions = [2, 2, 2]",
        "division = [2, 2, 2]",
        "line 13: [parts.block] has no field \"division\" (did you mean \"divisions\"?)",
    );
    refused("penalty", "penaltY", "[interface[1]] has no field \"penaltY\" (did you mean \"penalty\"?)");
    refused(
        "shape = \"box\"",
        "shap = \"box\"",
        "line 11: [parts.block] has no field \"shap\" (did you mean \"shape\"?)",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nxyzzy = 1",
        "[time] has no field \"xyzzy\"; it has end, increment",
    );
    refused(
        "size = [3.0, 3.0]",
        "size = [3.0, 3.0]\norigin = [0, 0, 0]",
        "[parts.floor] has no field \"origin\"",
    );
}

#[test]
fn misspelt_words_and_names_name_the_nearest() {
    refused(
        "title =",
        "contact = \"difuse\"\ntitle =",
        "contact cannot be \"difuse\" (did you mean \"diffuse\"?); it can be \"diffuse\", \"node-to-facet\", \"none\"",
    );
    refused(
        "shape = \"box\"",
        "shape = \"bax\"",
        "parts.block.shape cannot be \"bax\" (did you mean \"box\"?)",
    );
    refused(
        "material = \"steel\"",
        "material = \"stel\"",
        "line 14: no material is named \"stel\" (did you mean \"steel\"?); there is only steel",
    );
    refused(
        "\"block.z+\"",
        "\"blok.z+\"",
        "line 27: no node set is named \"blok.z+\" (did you mean \"block.z+\"?)",
    );
    // No set of the block is spelt like that, only all of the name is.
    refused(
        "\"block.z+\"",
        "\"block.top\"",
        "line 27: no node set is named \"block.top\"; there are block, block.x+",
    );
    refused(
        "surface = \"block.x+\"",
        "surface = \"block.crown\"",
        "line 31: no surface is named \"block.crown\"; there are block, block.x+",
    );
    refused(
        "slave = \"block.z-\"",
        "slave = [\"block.z-\", \"flor\"]",
        "no surface is named \"flor\" (did you mean \"floor\"?)",
    );
    refused("fix = [\"x\", \"y\", \"z\"]", "fix = [\"x\", \"w\"]", "boundary[1].fix[2] cannot be \"w\"");
}

/// Of 30 parts a list that begins with any names would not come to those that help.
#[test]
fn lists_of_names_begin_with_the_part_that_was_asked_for() {
    let mut text = changed("\"block.z+\"", "\"block.top\"");
    for k in 0..30 {
        text += &format!("\n[parts.a{k}]\nshape = \"rigid-plane\"\nsize = [1.0, 1.0]\ndivisions = [1, 1]\n");
    }
    let said = message(&text);
    let begin = "no node set is named \"block.top\"; there are block, block.x+, block.x-, block.y+, block.y-, block.z+, block.z-, ";
    assert!(said.contains(begin), "{said}");
    // Of a part that is misspelt as well.
    let said = message(&text.replace("\"block.top\"", "\"blok.zz\""));
    assert!(said.contains("; there are block.z+, block.z-, block, block.x+, "), "{said}");
    // Materials have no parts.
    let metals: String =
        (0..3).map(|k| format!("[materials.iron{k}]\nyoung = 1.0\npoisson = 0.3\n")).collect();
    let said = message(&format!("{}\n{metals}", changed("material = \"steel\"", "material = \"irn2\"")));
    assert!(said.contains("(did you mean \"iron2\"?); there are iron2, iron0, iron1, steel"), "{said}");
}

#[test]
fn wrong_types_and_ranges_say_what_was_found() {
    refused(
        "young = 200_000",
        "young = \"hard\"",
        "line 5: materials.steel.young must be a number, not the text \"hard\"",
    );
    refused(
        "young = 200_000",
        "young = -1.5",
        "materials.steel.young must be positive (1e-50 to 1e50), not -1.5",
    );
    refused("young = 200_000", "young = nan", "materials.steel.young must be finite, not NaN");
    refused("young = 200_000", "young = inf", "materials.steel.young must be finite, not inf");
    refused(
        "poisson = 0.3",
        "poisson = 0.5",
        "materials.steel.poisson must be above -1 and below 0.5, not 0.5",
    );
    refused(
        "size = [1.0, 1.0, 1.0]",
        "size = [1.0, 1.0]",
        "line 12: parts.block.size must be a list of three numbers, not a list of 2",
    );
    refused(
        "size = [1.0, 1.0, 1.0]",
        "size = [1.0, 0.0, 1.0]",
        "line 12: parts.block: size must be a positive length (1e-50 to 1e50), not 0",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [2, 2.5, 2]",
        "parts.block.divisions[2] must be a whole number, not 2.5",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [2, -2, 2]",
        "parts.block.divisions[2] must be at least 1, not -2",
    );
    refused(
        "divisions = [2, 2, 2]",
        "divisions = [999, 999, 99]",
        "line 13: parts.block: these divisions make 100000000 nodes; at most 20000000 are possible",
    );
    refused(
        "value = 10.0",
        "value = 10.0\nfollower = 1",
        "pressure[1].follower must be true or false, not 1",
    );
    refused(
        "value = 10.0",
        "value = 10.0\namplitude = [[0, 0], [2, 1], [1, 0]]",
        "pressure[1].amplitude: times must ascend, but point 3 is not later",
    );
    refused(
        "increment = 0.25",
        "increment = 2.0",
        "time.increment must be from 1e-9 times end to end, not 2",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nmaximum = 0.1",
        "time.maximum must be from increment to end, not 0.1",
    );
    refused(
        "translate = [0.0, \"free\", -0.2]",
        "translate = [0.0, \"fre\", -0.2]",
        "boundary[2].translate[2] must be a number or \"free\", not the text \"fre\"",
    );
    refused("nodes = \"floor\"", "nodes = []", "boundary[1].nodes must be a list of at least one name");
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nneighbours = { rule = \"nearest\", count = 25 }",
        "interface[1].neighbours.count must be from 1 to 24, not 25",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nneighbours = { rule = \"hull-layers\", regularity = 1.0 }",
        "interface[1].neighbours.regularity must be at least 0 and below 1, not 1",
    );
    assert_eq!(MAX_NEIGHBOURS, 24);
}

#[test]
fn coefficients_of_friction_are_refused_by_their_field_and_place() {
    let with = |coefficient: &str, expected: &str| {
        let friction =
            format!("penalty = 1e5\nareas = true\nfriction = {{ coefficient = {{ {coefficient} }} }}");
        refused("penalty = 1e5", &friction, &format!("interface[1].friction.coefficient{expected}"));
    };
    with("static = 0.3, kinetic = 0.2, decay = -1", ".decay must be at least 0, not -1");
    with("static = -0.3, kinetic = 0.2, decay = 1", ".static must be at least 0, not -0.3");
    with("static = 0.3, kinetic = inf, decay = 1", ".kinetic must be");
    with(
        "pressures = [0, 10], values = [0.1]",
        ".values must be 2 numbers, one for each pressure, not a list of 1",
    );
    with("rates = [0, 1], values = [0.1]", ".values must be 2 numbers, one for each rate, not a list of 1");
    with(
        "pressures = [0, 10, 10], values = [0.1, 0.2, 0.3]",
        ".pressures: numbers must ascend, but number 3 is not",
    );
    with("rates = [1, 0], values = [0.1, 0.2]", ".rates: numbers must ascend, but number 2 is not");
    with("rates = [0, nan], values = [0.1, 0.2]", ".rates[2] must be");
    with("rates = [0, 1], values = [0.1, -0.2]", ".values[2] must be at least 0, not -0.2");
    with("pressures = [], values = []", ".pressures must be a list of at least one number");
    let rows = "pressures = [0, 1], rates = [0, 1], values =";
    with(&format!("{rows} [[0.1, 0.2], [0.1, -0.2]]"), ".values[2][2] must be at least 0, not -0.2");
    with(&format!("{rows} [[0.1, 0.2]]"), ".values must be 2 rows, one for each pressure, not a list of 1");
    with(&format!("{rows} [[0.1, 0.2], [0.1]]"), ".values[2] must be 2 numbers, one for each rate");
    with(&format!("{rows} [0.1, 0.2, 0.3]"), ".values must be 2 rows, one for each pressure");
}

/// Over nodes with a penalty by node there is no pressure that a table or a limit could be in the unit of.
#[test]
fn friction_by_pressure_needs_one() {
    let limit = "friction = { coefficient = 0.3, shear_limit = 2.0 }";
    let table = "friction = { coefficient = { pressures = [0, 9], values = [0.3, 0.2] } }";
    let reason = "has no meaning over nodes with penalty and without `areas = true`, where there are forces and no pressures";
    for (friction, field) in [(limit, "shear_limit"), (table, "coefficient.pressures")] {
        for areas in ["", "areas = false\n"] {
            let fields = format!("penalty = 1e5\n{areas}{friction}");
            refused("penalty = 1e5", &fields, &format!("interface[1].friction.{field} {reason}"));
        }
        for fields in ["", "penalty = 1e5\nareas = true\n", "penalty = 1e5\nintegration = \"faces\"\n"] {
            Deck::parse(&changed("penalty = 1e5", &format!("{fields}{friction}"))).unwrap();
        }
    }
    let rates = "penalty = 1e5\nfriction = { coefficient = { rates = [0, 9], values = [0.3, 0.2] } }";
    Deck::parse(&changed("penalty = 1e5", rates)).unwrap();
}

/// Slaves follow by nodal domains in every iteration: a pairing anew instead would take that away.
#[test]
fn pairing_in_iterations_is_for_other_rules_than_domains() {
    let reason = "interface[1].refresh has no meaning with nodal domains, by which slaves follow";
    let iteration = "penalty = 1e5\nrefresh = \"iteration\"";
    let domains = format!("{iteration}\nneighbours = {{ rule = \"domains\" }}");
    refused("penalty = 1e5", iteration, reason);
    refused("penalty = 1e5", &domains, reason);
    let layers = format!("{iteration}\nneighbours = {{ rule = \"hull-layers\" }}");
    for fields in [&layers, "penalty = 1e5\nrefresh = \"increment\""] {
        Deck::parse(&changed("penalty = 1e5", fields)).unwrap();
    }
    let facets = changed("penalty = 1e5", iteration);
    Deck::parse(&format!("contact = \"node-to-facet\"\n{facets}")).unwrap();
}

#[test]
fn fields_that_do_not_go_together_are_refused() {
    refused(
        "yield_stress = 400.0\n",
        "",
        "line 7: materials.steel.hardening has no meaning without yield_stress",
    );
    refused(
        "fix = [\"x\", \"y\", \"z\"]",
        "fix = [\"x\"]\namplitude = [[0, 0]]",
        "boundary[1].amplitude has no meaning beside fix",
    );
    refused("fix = [\"x\", \"y\", \"z\"]", "", "[boundary[1]] needs fix, translate or rotate");
    refused(
        "translate = [0.0, \"free\", -0.2]",
        "translate = [0.0, \"free\", -0.2]\nrotate = { axis = [0, 0, 1], degrees = 9 }",
        "has no meaning beside rotate",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\naugmentation = { tolerance = 1.0 }",
        "interface[1].augmentation has no meaning without method",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nmethod = \"augmented-lagrangian\"",
        "[interface[1]] needs a table \"augmentation\"",
    );
    let over_faces = |fields: &str| format!("penalty = 1e5\nintegration = \"faces\"\n{fields}");
    refused(
        "penalty = 1e5",
        &over_faces("friction = { coefficient = 0.3, symmetric = true }"),
        "interface[1].friction.symmetric has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("areas = true"),
        "interface[1].areas has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("refresh = \"iteration\""),
        "interface[1].refresh has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        &over_faces("neighbours = { rule = \"nearest\" }"),
        "interface[1].neighbours has no meaning with integration over faces",
    );
    refused(
        "penalty = 1e5",
        "penalty = 1e5\nintegration = { over = \"nodes\", degree = 2 }",
        "degree has no meaning with over = \"nodes\"",
    );
    refused(
        "increment = 0.25",
        "increment = 0.25\nfixed = true\ngrowth = 2.0",
        "time.growth has no meaning beside fixed = true",
    );
    refused(
        "divisions = [3, 3]",
        "divisions = [3, 3]\nmaterial = \"steel\"",
        "parts.floor.material has no meaning for a rigid part",
    );
    refused(
        "shape = \"box\"",
        "shape = \"box\"\nfile = \"box.msh\"",
        "parts.block.shape has no meaning beside file",
    );
    refused(
        "shape = \"box\"\nsize = [1.0, 1.0, 1.0]\ndivisions = [2, 2, 2]",
        "",
        "[parts.block] needs either a shape or a file",
    );
    refused("material = \"steel\"\n", "", "[parts.block] needs a field \"material\"");
    refused("[time]\nincrement = 0.25", "", "the deck needs a table \"time\"");
    let second =
        "[[interface]]\nname = \"joint\"\nmaster = \"floor\"\nslave = \"block.x-\"\npenalty = 1\n[time]";
    refused("[time]", second, "two interfaces are named \"joint\"; the other is in line 35");
}

#[test]
fn contradictions_in_space_are_refused() {
    let twice = "[[boundary]]\nnodes = \"block.x+\"\nfix = [\"z\"]\n[[pressure]]";
    refused(
        "[[pressure]]",
        twice,
        "is moved along z by this boundary condition and, differently, by that in line 26",
    );
    // Along x both say that nothing moves, along y one of them says nothing.
    let alike =
        changed("[[pressure]]", "[[boundary]]\nnodes = \"block.x+\"\nfix = [\"x\", \"y\"]\n[[pressure]]");
    Deck::parse(&alike).unwrap().model(".").unwrap();

    refused(
        "fix = [\"x\", \"y\", \"z\"]",
        "fix = [\"x\", \"z\"]",
        "line 16: the part \"floor\" is rigid, but its node at (-1, -1, -0.1) is free along y",
    );
    refused("surface = \"block.x+\"", "surface = \"floor\"", "the surface \"floor\" is rigid");
    refused("slave = \"block.z-\"", "slave = \"floor\"", "on both sides of the interface \"joint\"");
    let floor = "[parts.lid]\nshape = \"rigid-plane\"\nsize = [1, 1]\ndivisions = [1, 1]\n[parts.floor]";
    let rigid = changed("[parts.floor]", floor)
        .replace("slave = \"block.z-\"", "slave = \"lid\"")
        .replace("nodes = \"floor\"", "nodes = [\"floor\", \"lid\"]");
    assert!(message(&rigid).contains("both sides of the interface \"joint\" are rigid"));
    let nothing =
        "[parts.floor]\nshape = \"rigid-plane\"\nsize = [1, 1]\ndivisions = [1, 1]\n[time]\nincrement = 1";
    assert!(message(nothing).contains("the deck has no deformable part"));
}

/// Squares of stresses overflow long before the moduli do.
#[test]
fn moduli_are_bounded_as_lengths_are() {
    for value in ["1e51", "1e300", "1e-60"] {
        let range = "must be positive (1e-50 to 1e50), not";
        refused("young = 200_000", &format!("young = {value}"), &format!("materials.steel.young {range}"));
        let yields = format!("materials.steel.yield_stress {range}");
        refused("yield_stress = 400.0", &format!("yield_stress = {value}"), &yields);
    }
    refused("hardening = 3450.0", "hardening = 1e51", "hardening must be at least 0 and at most 1e50");
}

/// A deck can forge no message of its own, nor speak to the terminal, whichever of its names is wrong.
#[test]
fn names_of_a_deck_are_shown_in_one_line_of_limited_length() {
    let long = "x".repeat(5000);
    let hostile = |text: &str| text.replace('!', &format!("\\u001B]0;t\\u0007\\nerror: forged {long}"));
    for (from, to) in [
        ("poisson = 0.3", "\"!\" = 0.3"),
        ("[parts.block]", "[parts.\"!.\"]"),
        ("material = \"steel\"", "material = \"!\""),
        ("surface = \"block.x+\"", "surface = \"!\""),
        ("shape = \"box\"", "shape = \"!\""),
        ("young = 200_000", "young = \"!\""),
    ] {
        let error =
            Deck::parse(&changed(from, &hostile(to))).and_then(|deck| deck.model(".").map(drop)).unwrap_err();
        let said = error.to_string();
        assert!(!said.contains(char::is_control), "{from}: {said:?}");
        assert!(said.contains("forged") && said.len() < 1000, "{from}: {said}");
    }
    let many: String = (0..3000).map(|k| format!("[materials.m{k}]\nyoung = 1.0\npoisson = 0.3\n")).collect();
    let text = changed("material = \"steel\"", "material = \"gold\"") + &many;
    let said = Deck::parse(&text).unwrap().model(".").unwrap_err().to_string();
    assert!(said.len() < 500 && said.ends_with(" more"), "{said}");
}

#[test]
fn a_tangent_that_is_no_operator_is_refused() {
    let with = |newton: &str| {
        format!("[time]\nincrement = 0.25\n[newton]\ncontact_tangent = \"operator\"\n{newton}")
    };
    let cases = [
        ("linear_solver = \"direct\"", "", "as an operator beside linear_solver = \"direct\""),
        (
            "",
            "friction = { coefficient = 0.3, symmetric = true }\n",
            "as an operator beside a symmetric tangent of friction",
        ),
        ("", "integration = \"faces\"\n", "as an operator beside integration over faces"),
    ];
    for (newton, interface, reason) in cases {
        let text = changed("[time]\nincrement = 0.25", &with(newton));
        let text = text.replace("penalty =", &format!("{interface}penalty ="));
        let expected = format!("newton.contact_tangent has no meaning {reason}");
        let found = message(&text);
        assert!(found.contains(&expected), "{found}\ndoes not contain\n{expected}");
    }
}

/// Friction takes a turn by 360° for none, and one by 350° for one of 10° the other way.
#[test]
fn a_turn_that_friction_cannot_follow_is_refused() {
    let with = |rotate: &str, interface: &str, time: &str| {
        let text =
            changed("fix = [\"x\", \"y\", \"z\"]", &format!("rotate = {{ axis = [0, 0, 1], {rotate} }}"));
        let text = text.replace("penalty =", &format!("{interface}penalty ="));
        text.replace("increment = 0.25", time)
    };
    let friction = "friction = 0.3\n";
    for (rotate, interface, time) in [
        ("degrees = 720", "", "increment = 0.25"),
        ("degrees = -716", friction, "increment = 0.25"),
        ("degrees = -720", friction, "increment = 0.125"),
        ("degrees = 720", "friction = 0.0\n", "increment = 0.25"),
        ("degrees = 720, amplitude = [[0, 0], [1, 0], [2, 1]]", friction, "increment = 0.25"),
        // A point of the amplitude ends the increment.
        ("degrees = 720, amplitude = [[0, 0], [0.2, 0.2], [1, 0.2]]", friction, "increment = 0.25"),
    ] {
        let text = with(rotate, interface, time);
        assert!(Deck::parse(&text).is_ok(), "{text}");
    }
    for (rotate, time, said) in [
        (
            "degrees = 720",
            "increment = 0.25",
            "line 22: this boundary condition turns by 180° in an increment of 0.25",
        ),
        ("degrees = -1440", "increment = 0.25\nfixed = true", "turns by 360° in an increment of 0.25"),
        ("degrees = 360", "increment = 0.125\nmaximum = 0.75", "turns by 270° in an increment of 0.75,"),
        (
            "degrees = 200, amplitude = [[0, 1], [1, 1]]",
            "increment = 0.25",
            "turns by 200° in an increment of 0.25,",
        ),
        (
            "degrees = 400, amplitude = [[0, 0], [0.2, 0.5]]",
            "increment = 0.25",
            "turns by 200° in an increment of 0.2,",
        ),
    ] {
        let found = Deck::parse(&with(rotate, friction, time)).unwrap_err().to_string();
        assert!(found.contains(said), "{found}\ndoes not contain\n{said}");
    }
    // Two of them: against one another, and along.
    let both = |axis: &str| {
        let text = with("degrees = 400", friction, "increment = 0.25");
        let other = format!("rotate = {{ axis = {axis}, degrees = 400 }}");
        Deck::parse(&text.replacen(
            "[[boundary]]",
            &format!("[[boundary]]\nnodes = \"block.z+\"\n{other}\n\n[[boundary]]"),
            1,
        ))
    };
    // Along, against, and about other axes, where no angle between them is beyond 180°.
    assert!(both("[0, 0, 3]").is_ok() && both("[0, -1, -1]").is_ok());
    let found = both("[0, 0, -1]").unwrap_err().to_string();
    assert!(found.contains("turns by 200° in an increment of 0.25"), "{found}");
}
