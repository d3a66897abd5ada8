//! `report.html`, opened in a browser.

use std::fs;
use std::path::Path;
use std::process::Command;

use diffuse_contact_solver::output::{History, HistoryRow, Skin, SkinFrame, Summary, read_history};

use crate::decks::{BLOCK, block_in, failing};
use crate::runs::{Scratch, run};

/// With this variable set a missing browser fails a test; without it the test says so and passes.
const REQUIRE: &str = "DIFFUSE_CONTACT_REQUIRE_TOOLS";

/// The page after its script has run, or nothing where there is no browser.
fn opened(scratch: &Scratch, page: &str) -> Option<String> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = names.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    let Some(browser) = found else {
        assert!(std::env::var_os(REQUIRE).is_none(), "there is no browser among {names:?}");
        eprintln!("skipped: there is no browser among {names:?} to open {page} with");
        return None;
    };
    let profile = format!("--user-data-dir={}", scratch.path("profile"));
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--enable-unsafe-swiftshader",
            "--no-first-run",
        ])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync", &profile])
        // No host is found: what the page needs it holds.
        .args(["--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1240,1800"])
        .args(["--virtual-time-budget=10000", "--dump-dom", &format!("file://{page}")])
        .output()
        .unwrap();
    Some(String::from_utf8(output.stdout).unwrap())
}

/// What an expression of the page's script is once all is drawn, or nothing where there is no browser.
fn asked(scratch: &Scratch, page: &str, expression: &str) -> Option<serde_json::Value> {
    let says = format!(
        "<script>setInterval(() => {{ if (document.body.dataset.ready)\
         document.body.dataset.said = JSON.stringify({expression}) }}, 100)</script></body>"
    );
    let text = fs::read_to_string(page).unwrap();
    let end = text.rfind("</body>").unwrap();
    let asking = format!("{}{says}{}", &text[..end], &text[end + "</body>".len()..]);
    let dom = opened(scratch, &scratch.file("asking.html", &asking))?;
    let said = dom.split("data-said=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("an answer");
    Some(serde_json::from_str(&said.replace("&quot;", "\"")).unwrap())
}

/// Width of a telephone held upright. Browser windows are wider, but not frames.
const NARROW: u32 = 390;

/// Asserts that nothing of a page sticks out of a narrow frame.
#[track_caller]
fn assert_fits(scratch: &Scratch, page: &str) {
    let text = fs::read_to_string(page).unwrap();
    // Browsers keep pages of files apart: the page itself says how wide it is.
    let says = "<script>setInterval(() => {\
        const root = document.documentElement, ready = document.body.dataset.ready;\
        parent.postMessage(`${ready} ${innerWidth} ${root.scrollWidth} ${root.clientWidth}`, '*');\
    }, 100)</script></body>";
    let end = text.rfind("</body>").unwrap();
    scratch.file("inner.html", &format!("{}{says}{}", &text[..end], &text[end + "</body>".len()..]));
    let frame = format!(
        "<!DOCTYPE html><body><iframe src=\"inner.html\" style=\"width: {NARROW}px; height: 1800px; border: 0\"></iframe>\
         <script>onmessage = event => {{ document.body.dataset.widths = event.data }}</script></body>"
    );
    let Some(dom) = opened(scratch, &scratch.file("frame.html", &frame)) else { return };
    let said = dom.split("data-widths=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let [ready, inner, content, shown] = said.split(' ').collect::<Vec<_>>()[..] else { panic!("{said}") };
    assert_eq!((ready, inner), ("true", &*NARROW.to_string()), "{said}");
    assert!(content.parse::<u32>().unwrap() <= shown.parse().unwrap(), "{said}");
}

/// The start tag of the element with this id.
fn tag<'a>(page: &'a str, id: &str) -> &'a str {
    let at = page.find(&format!(" id=\"{id}\"")).unwrap_or_else(|| panic!("no element {id}"));
    let start = page[..at].rfind('<').unwrap();
    &page[start..start + page[start..].find('>').unwrap()]
}

const PLANE: [&str; 3] = ["force", "iterations", "convergence"];

#[track_caller]
fn assert_drawn(dom: &str, runs: usize, surfaces: bool) {
    let body = &dom[dom.find("<body").unwrap()..];
    let body = &body[..body.find('>').unwrap()];
    assert!(body.contains("data-ready=\"true\""), "{body}");
    assert!(!body.contains("data-error"), "{body}");
    for id in PLANE {
        assert!(tag(dom, id).contains(&format!("data-drawn=\"{runs}\"")), "{}", tag(dom, id));
        let plot = &dom[dom.find(&format!(" id=\"{id}\"")).unwrap()..];
        assert!(plot.contains("class=\"main-svg\""), "{id}");
    }
    assert!(tag(dom, "shape").contains("data-drawn="), "{}", tag(dom, "shape"));
    for id in ["surfaces", "contact"] {
        assert_eq!(dom.contains(&format!("id=\"{id}\"")), surfaces, "{id}");
    }
    if surfaces {
        assert!(tag(dom, "contact").contains(&format!("data-drawn=\"{runs}\"")), "{}", tag(dom, "contact"));
        assert!(tag(dom, "surfaces").contains("data-drawn="), "{}", tag(dom, "surfaces"));
    }
    // The script's own text mentions NaN; what it wrote does not.
    let written = &dom[dom.find("<main").unwrap()..dom.find("</main>").unwrap()];
    assert!(!written.contains("NaN") && !written.contains("undefined"), "{written}");
}

#[test]
fn both_elements_are_drawn_together() {
    let scratch = Scratch::new("report-two");
    let deck = scratch.file("block.toml", &block_in(4));
    let classic = scratch.file("classic.toml", &format!("contact = \"node-to-facet\"\n{}", block_in(4)));
    let (one, two, page) = (scratch.path("one"), scratch.path("two"), scratch.path("page.html"));
    assert_eq!(run(&["solve", &deck, "--out", &one]).code, 0);
    assert_eq!(run(&["solve", &classic, "--out", &two]).code, 0);
    let written = run(&["report", &one, &two, "-o", &page]);
    assert_eq!((written.code, written.stderr), (0, format!("wrote {page}\n")));
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("<title>Block &amp; &lt;wave&gt;</title>"));
    for loaded in ["src=\"http", "href=\"http", "@import", "src=\"//"] {
        let own = &text[text.rfind("</head>").unwrap()..];
        assert!(!own.contains(loaded), "{loaded}");
    }
    assert_eq!(text.matches("<script src").count(), 0);
    if let Some(dom) = opened(&scratch, &page) {
        assert_drawn(&dom, 2, true);
        assert!(!dom.contains("dissipated energy, force · length</option>"));
        assert!(dom.contains("Block &amp; &lt;wave&gt;</h1>"));
        let words = ["diffuse", "node-to-facet", "reaction x, force", "displacement x, length", "CSV", "PNG"];
        for word in words {
            assert!(dom.contains(word), "{word}");
        }
    }
    assert_fits(&scratch, &page);
    if let Some(dom) = opened(&scratch, &format!("{one}/report.html")) {
        assert_drawn(&dom, 1, true);
    }
}

#[test]
fn a_run_without_a_finished_increment_has_a_report() {
    let scratch = Scratch::new("report-none");
    let deck = scratch.file("failing.toml", &failing("[[0.0, 0.0], [1.0, 1.0]]"));
    let out = scratch.path("out");
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 1);
    if let Some(dom) = opened(&scratch, &format!("{out}/report.html")) {
        assert_drawn(&dom, 1, true);
        assert!(dom.contains("diffuse ended early: no convergence after time 0"));
        assert!(dom.contains("no finished increment"));
        // Its iterations, where it was left, and who is out of balance there.
        assert!(tag(&dom, "failed").contains("data-drawn=\"1\""), "{}", tag(&dom, "failed"));
        let worst = &dom[dom.find("id=\"worst\"").unwrap()..];
        let worst = &worst[..worst.find("</table>").unwrap()];
        assert!(worst.matches("<tr>").count() == 11 && worst.contains("<td>block</td>"), "{worst}");
    }
    assert_fits(&scratch, &format!("{out}/report.html"));
    let failed: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(Path::new(&out).join("failed.json")).unwrap()).unwrap();
    let size = |node: &serde_json::Value| {
        let force = node["residual"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap());
        force.map(|x| x * x).sum::<f64>()
    };
    let sizes: Vec<f64> = failed["worst"].as_array().unwrap().iter().map(size).collect();
    assert!(sizes.len() == 10 && sizes.is_sorted_by(|a, b| a >= b) && sizes[9] > 0.0, "{sizes:?}");
    let count = |name: &str| failed[name].as_array().map_or(0, Vec::len);
    assert!(count("residuals") > 0 && failed["frame"].is_object());
    assert_eq!((count("iterations"), &failed["iterations"][0]), (count("residuals"), &0.into()));
}

#[test]
fn names_in_a_deck_are_text_in_the_page() {
    let scratch = Scratch::new("report-names");
    let hostile = r#"</script><!--<script>@DATA@ @SCRIPT@ \"&amp;"#;
    let deck = block_in(2)
        .replace("Block & <wave>", hostile)
        .replace("name = \"floor\"", "name = \"</script><b>, @DATA@\"");
    let deck = scratch.file("hostile.toml", &deck);
    let out = scratch.path("out");
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let Some(dom) = opened(&scratch, &format!("{out}/report.html")) else { return };
    assert_drawn(&dom, 1, true);
    let heading = "&lt;/script&gt;&lt;!--&lt;script&gt;@DATA@ @SCRIPT@ \"&amp;amp;</h1>";
    assert!(dom.contains(heading), "{}", &dom[dom.find("<h1").unwrap()..][..200]);
    assert!(!dom.contains("<b>"));
}

#[test]
fn a_run_without_contact_has_no_surfaces_to_show() {
    let scratch = Scratch::new("report-plain");
    let plain = BLOCK.replace("[[boundary]]\nnodes = \"block.z+\"", "[[boundary]]\nnodes = \"block.z-\"\nfix = [\"x\", \"y\", \"z\"]\n\n[[boundary]]\nnodes = \"block.z+\"");
    let plain = plain[..plain.find("[[interface]]").unwrap()].to_owned()
        + "[time]\nincrement = 0.5\n[output]\nstress = false\n";
    let deck = scratch.file("plain.toml", &plain);
    let out = scratch.path("out");
    let solved = run(&["solve", &deck, "--out", &out]);
    assert_eq!(solved.code, 0, "{solved:?}");
    if let Some(dom) = opened(&scratch, &format!("{out}/report.html")) {
        assert_drawn(&dom, 1, false);
        assert!(!dom.contains("von Mises stress</option>"));
    }
}

#[test]
fn results_that_are_missing_or_damaged_are_refused_in_a_sentence() {
    let scratch = Scratch::new("report-damaged");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    let page = scratch.path("page.html");
    run(&["report", &scratch.path("absent"), "-o", &page])
        .assert_refused(&["absent", "there is no such file"]);
    run(&["report"]).assert_refused(&["DIR"]);
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    run(&["report", &out, "-o", &scratch.path("none/page.html")]).assert_refused(&["page.html"]);
    for name in [
        "summary.json",
        "history.csv",
        "iterations.csv",
        "skins/skin.json",
        "skins/00002.json",
        "skins/surfaces.json",
    ] {
        let path = Path::new(&out).join(name);
        let whole = fs::read_to_string(&path).unwrap();
        for damaged in [whole.replacen(|letter: char| letter.is_ascii_digit(), "x", 3), "[".to_owned()] {
            fs::write(&path, damaged).unwrap();
            run(&["report", &out, "-o", &page]).assert_refused(&[name.rsplit('/').next().unwrap()]);
        }
        fs::write(&path, whole).unwrap();
    }
    assert!(!Path::new(&page).exists());
    // Indices that lead elsewhere would stop the page's script.
    let skin = Path::new(&out).join("skins/skin.json");
    let whole = fs::read_to_string(&skin).unwrap();
    fs::write(&skin, whole.replacen("\"faces\":[[", "\"faces\":[[99999,", 1)).unwrap();
    run(&["report", &out, "-o", &page]).assert_refused(&["skin.json"]);
    fs::write(&skin, whole).unwrap();
    assert_eq!(run(&["report", &out, "-o", &page]).code, 0);
}

#[test]
fn a_run_that_was_killed_has_a_report_of_its_increments() {
    let scratch = Scratch::new("report-killed");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    // What is written at the end.
    for name in ["summary.json", "skins/surfaces.json", "report.html"] {
        fs::remove_file(Path::new(&out).join(name)).unwrap();
    }
    let page = scratch.path("page.html");
    assert_eq!(run(&["report", &out, "-o", &page]).code, 0);
    let Some(dom) = opened(&scratch, &page) else { return };
    assert!(dom.contains("the run has not ended"));
    assert!(dom.contains("data-ready=\"true\"") && !dom.contains("data-error=\""));
    for id in PLANE.into_iter().chain(["contact", "shape"]) {
        assert!(tag(&dom, id).contains("data-drawn="), "{}", tag(&dom, id));
    }
    assert!(!dom.contains("id=\"surfaces\""));
}

#[test]
fn results_are_not_replaced_by_their_report() {
    let scratch = Scratch::new("report-onto");
    let (deck, out) = (scratch.file("block.toml", &block_in(2)), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    for name in ["state.json", "deck.toml", "skins/00001.json", "results/new.html"] {
        let target = format!("{out}/{name}");
        let before = fs::read(&target).ok();
        run(&["report", &out, "-o", &target]).assert_refused(&[name, "is the input file"]);
        assert_eq!(fs::read(&target).ok(), before, "{name}");
    }
    #[cfg(unix)]
    {
        let link = scratch.path("link.html");
        std::os::unix::fs::symlink(format!("{out}/state.json"), &link).unwrap();
        run(&["report", &out, "-o", &link]).assert_refused(&["is the input file"]);
    }
    assert_eq!(run(&["report", &out, "-o", &format!("{out}/report.html")]).code, 0);
    for _ in 0..2 {
        assert_eq!(run(&["report", &out, "-o", &format!("{out}/mine.html")]).code, 0);
    }
    // Nor is anything else that is no page.
    let pinch = scratch.file("pinch.toml", "mine");
    run(&["report", &out, "-o", &pinch]).assert_refused(&["pinch.toml", "is no page"]);
    assert_eq!(fs::read_to_string(&pinch).unwrap(), "mine");
    assert_eq!(run(&["report", &out, "-o", &scratch.file("empty.html", "")]).code, 0);
}

/// A number of a line's column.
fn column(history: &History, row: &HistoryRow, name: &str) -> f64 {
    assert!(history.columns.iter().any(|column| column == name), "{name}");
    history.value(row, name)
}

/// Rounds of augmentation begin with a residual that took no solution. On the way the increment that is shown is the one of most iterations.
#[test]
fn residuals_stand_over_their_linear_solutions() {
    for (extrapolation, first) in [("none", 1.0), ("linear", 0.0)] {
        let scratch = Scratch::new(&format!("report-rounds-{extrapolation}"));
        let deck = block_in(4).replace(
            "refresh = \"increment\"",
            "method = \"augmented-lagrangian\"\naugmentation = { tolerance = 1e-4 }",
        ) + &format!("[newton]\nextrapolation = \"{extrapolation}\"\n");
        let (deck, out) = (scratch.file("block.toml", &deck), scratch.path("out"));
        assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
        let history = read_history(&Path::new(&out).join("history.csv")).unwrap();
        let iterations = read_history(&Path::new(&out).join("iterations.csv")).unwrap();
        let says = "[Number(element(\"increment\").value), element(\"convergence\").data[0].x]";
        let Some(said) = asked(&scratch, &format!("{out}/report.html"), says) else { return };
        let (number, shown): (usize, Vec<f64>) = serde_json::from_value(said).unwrap();
        let rows = iterations.rows.iter().filter(|row| row.increment == number);
        let solutions: Vec<f64> = rows.map(|row| iterations.value(row, "iteration")).collect();
        assert_eq!(shown, solutions[solutions.len() - shown.len()..]);
        assert_eq!(
            shown[0], first,
            "the first of {solutions:?} is left out, unless it is that of an extrapolation"
        );
        assert_eq!(*shown.last().unwrap(), column(&history, &history.rows[number - 1], "iterations"));
        assert!(shown.len() > 1 + *shown.last().unwrap() as usize, "rounds: {shown:?}");
    }
}

/// Nodes without a gap have a zero in the results, and that is no gap.
#[test]
fn the_least_and_the_largest_gap_are_gaps() {
    let scratch = Scratch::new("report-gaps");
    let deck = scratch.file("block.toml", &format!("{}[output]\ncolour = \"gap\"\n", block_in(4)));
    let out = scratch.path("out");
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let read = |name: &str| fs::read_to_string(Path::new(&out).join(name)).unwrap();
    let (skin, frame): (Skin, SkinFrame) = (
        serde_json::from_str(&read("skins/skin.json")).unwrap(),
        serde_json::from_str(&read("skins/00004.json")).unwrap(),
    );
    let [gap, status] = ["contact_gap", "contact_status"].map(|name| &frame.fields[name]);
    let mut gaps: Vec<(f64, usize)> = (0..gap.len())
        .filter(|&k| [2.0, 3.0].contains(&status[k]))
        .map(|k| (gap[k], skin.nodes[k]))
        .collect();
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(gaps.len() < gap.len() && gaps[gaps.len() - 1].0 < 0.0, "a zero would be the largest: {gaps:?}");
    let says = "element(\"extremes\").textContent.match(/at node [0-9]+/g)";
    let Some(said) = asked(&scratch, &format!("{out}/report.html"), says) else { return };
    let named: [String; 2] = serde_json::from_value(said).unwrap();
    for (name, end) in named.iter().zip([gaps[0].0, gaps[gaps.len() - 1].0]) {
        // The page has seven digits, of which several nodes may have the same.
        let node: usize = name.trim_start_matches("at node ").parse().unwrap();
        let (own, _) = gaps.iter().find(|(_, other)| *other == node).expect("a slave with a gap");
        assert!((own / end - 1.0).abs() < 1e-6, "{name}: {own}, {end}");
    }
}

/// What slides at the end, its traction and what it has dissipated: in numbers, on the skin and in the page.
#[test]
fn friction_is_in_the_summary_on_the_skin_and_in_the_page() {
    let scratch = Scratch::new("report-friction");
    let faces = "name = \"floor\"\nintegration = \"faces\"\nfriction = 0.1";
    let deck = block_in(8).replace("refresh = \"increment\"\n", "").replace("name = \"floor\"", faces);
    let (deck, out) = (scratch.file("block.toml", &deck), scratch.path("out"));
    assert_eq!(run(&["solve", &deck, "--out", &out]).code, 0);
    let read = |name: &str| fs::read_to_string(Path::new(&out).join(name)).unwrap();

    let history = read_history(&Path::new(&out).join("history.csv")).unwrap();
    let row = history.rows.last().unwrap();
    let last = |name: &str| column(&history, row, name);
    let summary: Summary = serde_json::from_str(&read("summary.json")).unwrap();
    let friction = summary.friction["floor"];
    assert_eq!(summary.friction.len(), 1);
    assert_eq!(
        [friction.stuck as f64, friction.sliding as f64],
        [last("stuck:floor"), last("sliding:floor")]
    );
    assert_eq!(friction.dissipated, last("dissipated:floor"));
    assert_eq!(friction.traction, last("friction_force:floor") / last("contact_area:floor"));
    // Nearly all slides: friction is 0.1 of the normal force.
    let ratio = last("friction_force:floor") / last("contact_normal_force:floor");
    assert!(friction.sliding > 10 && (0.09..0.1001).contains(&ratio), "{friction:?} {ratio}");
    let dissipated = history.rows.iter().map(|row| column(&history, row, "dissipated:floor"));
    assert!(friction.dissipated > 0.0 && dissipated.is_sorted());

    let frame: SkinFrame = serde_json::from_str(&read("skins/00008.json")).unwrap();
    let field = |name: &str| &frame.fields[name];
    let sliding: Vec<usize> =
        (0..frame.positions.len()).filter(|&node| field("friction_status")[node] == 2.0).collect();
    assert_eq!(sliding.len(), friction.sliding);
    for node in sliding {
        let (traction, pressure) = (field("contact_friction")[node], field("contact_pressure")[node]);
        assert!((traction / pressure - 0.1).abs() < 1e-3, "{traction} {pressure}");
    }
    if let Some(dom) = opened(&scratch, &format!("{out}/report.html")) {
        assert_drawn(&dom, 1, true);
        for shown in [
            "dissipated energy, force · length</option>",
            "friction traction</option>",
            "<td>dissipated energy</td>",
        ] {
            assert!(dom.contains(shown), "{shown}");
        }
    }
}
