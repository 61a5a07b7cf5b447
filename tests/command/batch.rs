//! Tables of views: any number of them, stopped and continued, by several processes.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::{Child, Stdio};
use std::time::{Duration, SystemTime};

use super::*;

const NOISE: [&str; 4] = ["--photons", "500", "--noise-seed", "9"];

/// Rows of C-arm views that all differ.
fn table(rows: usize) -> String {
    let row = |n: usize| format!("{},{},{}\n", 3.7 * n as f64, 900 + n, 0.3 * n as f64);
    "angle_degrees,sad_mm,offset_z_mm\n".to_owned() + &(0..rows).map(row).collect::<String>()
}

fn write(folder: &TempDir, name: &str, text: &str) {
    std::fs::write(folder.path().join(name), text).expect("written");
}

/// What a run takes that makes the views of `views.csv` of the raw CT.
fn arguments<'a>(others: &[&[&'a str]], output: &'a str) -> Vec<&'a str> {
    let own = ["project", "--views", "views.csv", "--no-check", "--output", output];
    [&own[..], &RAW, &SMALL, &others.concat()].concat()
}

fn start(folder: &TempDir, arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drr"));
    command.args(arguments).current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::inherit());
    command.spawn().expect("the command starts")
}

/// Every file of a folder, hidden ones too.
fn all(folder: &TempDir, name: &str) -> BTreeMap<String, Vec<u8>> {
    let at = folder.path().join(name);
    files(&at).into_iter().map(|file| (file.clone(), bytes(&at, &file))).collect()
}

fn assert_same(own: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>) {
    let names = own.keys().chain(other.keys());
    let differing: Vec<_> = names.filter(|name| own.get(*name) != other.get(*name)).collect();
    assert!(differing.is_empty(), "{differing:?}");
}

fn is(name: &str, ending: &str) -> bool {
    Path::new(name).extension().is_some_and(|own| own == ending)
}

fn refused(folder: &TempDir, arguments: &[&str]) -> String {
    let output = drr(folder.path(), arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert_eq!(error.trim_end().lines().count(), 1, "{error}");
    error
}

#[test]
fn a_row_has_the_bytes_of_a_call_of_its_own() {
    let folder = write_inputs();
    write(
        &folder,
        "views.csv",
        "name,pixel_mm,angle_degrees,sdd_mm\nleft,6,-6,1500\nfront,5.5,0.1,1400\nright.2,6,1e1,1500\n",
    );
    let effects = [&NOISE[..], &["--focal-spot", "3", "--blur", "2"]].concat();
    let output = succeed(folder.path(), &arguments(&[&effects, &["--raw"]], "all"));
    assert!(output.contains("3 view(s) made") && output.contains("0 finished before"), "{output}");
    let views = [["-6", "6", "1500"], ["0.1", "5.5", "1400"], ["1e1", "6", "1500"]];
    for ((number, name), [angle, pixel, sdd]) in
        ["left", "front", "right.2"].into_iter().enumerate().zip(views)
    {
        let first = number.to_string();
        let alone =
            ["project", "--size", "22x14", "--raw", "--no-check", "--output", "one", "--first-view", &first];
        let view = ["--angles", angle, "--pixel", pixel, "--sdd", sdd];
        succeed(folder.path(), &[&alone[..], &view, &RAW, &effects].concat());
        for ending in [".exr", "_intensity.f32", "_line_integral.f32"] {
            let alone = bytes(folder.path(), &format!("one/view{number}{ending}"));
            assert!(bytes(folder.path(), &format!("all/{name}{ending}")) == alone, "{name}{ending}");
        }
    }
    let noise = |number: &str| {
        let own =
            [&["--angles", "5", "--first-view", number, "--raw", "--output", "noise"], &RAW[..], &NOISE];
        project(folder.path(), &[&own.concat()]);
        bytes(folder.path(), &format!("noise/view{number}_intensity.f32"))
    };
    assert!(noise("1") != noise("2"), "the number decides the noise");
}

#[test]
fn poses_say_the_same_as_a_c_arm() {
    let folder = write_inputs();
    write(&folder, "views.csv", &table(3));
    succeed(folder.path(), &arguments(&[&NOISE], "c_arm"));
    let axes = |name: &str| ["x", "y", "z"].map(|axis| format!("{name}_{axis}_mm")).join(",");
    let mut text = ["source", "row_step", "column_step", "first_pixel"].map(axes).join(",") + "\n";
    for n in 0..3 {
        let centre = grid().centre() + DVec3::new(0.0, 0.0, 0.3 * f64::from(n));
        let pose = DetectorPose::c_arm(centre, 3.7 * f64::from(n), f64::from(900 + n), 1500.0, 6.0, [22, 14]);
        let vectors = [pose.source, pose.row_step, pose.column_step, pose.first_pixel];
        let row = vectors.map(|v| format!("{},{},{}", v.x, v.y, v.z)).join(",");
        writeln!(text, "{row}").expect("a string");
    }
    write(&folder, "views.csv", &text);
    succeed(folder.path(), &arguments(&[&NOISE], "poses"));
    assert_same(&all(&folder, "c_arm"), &all(&folder, "poses"));
}

#[test]
fn two_processes_side_by_side_make_what_one_makes() {
    let folder = write_inputs();
    write(&folder, "views.csv", &table(41));
    for planned in [&["--tolerance-hu", "20"][..], &NOISE] {
        let whole = succeed(folder.path(), &arguments(&[planned], "whole"));
        assert!(whole.contains("41 view(s), 0 finished before: shard 1/1 of 41 rows"), "{whole}");
        let shards =
            ["1/2", "2/2"].map(|shard| start(&folder, &arguments(&[planned, &["--shard", shard]], "shards")));
        for mut shard in shards {
            assert!(shard.wait().expect("it ends").success());
        }
        let (own, expected) = (all(&folder, "shards"), all(&folder, "whole"));
        assert_eq!(own.len(), 41 + 2);
        assert_same(&own, &expected);
        // All of it is there: each shard sees its own.
        let again = succeed(folder.path(), &arguments(&[planned, &["--shard", "2/2"]], "shards"));
        assert!(again.contains("0 view(s), 20 finished before: shard 2/2 of 41 rows"), "{again}");
        // One row alone is a shard, too.
        succeed(folder.path(), &arguments(&[planned, &["--shard", "8/41"]], "row"));
        let row = all(&folder, "row");
        assert_eq!(row.keys().collect::<Vec<_>>(), ["made_of.json", "plan.json", "view000007.exr"]);
        assert!(row["view000007.exr"] == expected["view000007.exr"]);
        for output in ["whole", "shards", "row"] {
            std::fs::remove_dir_all(folder.path().join(output)).expect("removed");
        }
    }
}

/// The lines of a text that follow this one, without their indentation, up to an empty one.
fn example(text: &str, first: &str) -> String {
    let lines = text.lines().map(str::trim).skip_while(|line| *line != first);
    lines.take_while(|line| !line.is_empty()).fold(String::new(), |all, line| all + line + "\n")
}

#[test]
#[cfg(unix)]
fn the_example_of_the_help_does_what_it_says() {
    let folder = write_inputs();
    let help = succeed(folder.path(), &["project", "--help"]);
    write(&folder, "views.csv", &example(&help, "name,angle_degrees,sad_mm,offset_z_mm"));
    let script = example(&help, "# Two processes on one machine").replace("chest.nii", "ct.nii.gz");
    assert_eq!(script.matches("--shard").count(), 2, "{script}");
    let drr = Path::new(env!("CARGO_BIN_EXE_drr")).parent().expect("a folder").display();
    let path = format!("{drr}:{}", std::env::var("PATH").unwrap_or_default());
    let mut shell = Command::new("sh");
    let shell = shell.args(["-c", &script]).env("PATH", path).current_dir(folder.path());
    let output = shell.output().expect("a shell");
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let whole = ["project", "--ct", "ct.nii.gz", "--views", "views.csv", "--output", "whole", "--quiet"];
    succeed(folder.path(), &whole);
    let expected = all(&folder, "whole");
    assert_eq!(
        expected.keys().collect::<Vec<_>>(),
        ["case1_a.exr", "case1_b.exr", "made_of.json", "plan.json"]
    );
    let views = |name: &str| all(&folder, name).into_iter().filter(|(name, _)| name != "plan.json").collect();
    // The plan tells what is expected to take how long with so many threads.
    assert_same(&views("out"), &views("whole"));
}

#[test]
fn a_run_that_is_killed_goes_on_where_it_was() {
    const ROWS: usize = 150;
    let folder = write_inputs();
    write(&folder, "views.csv", &table(ROWS));
    let slow = ["--raw", "--supersample", "4", "--threads", "1"];
    succeed(folder.path(), &arguments(&[&NOISE, &slow], "whole"));
    let at = folder.path().join("killed");
    let made = || files(&at).into_iter().filter(|name| is(name, "exr")).collect::<Vec<_>>();
    let mut run = start(&folder, &arguments(&[&NOISE, &slow], "killed"));
    while !at.is_dir() || made().len() < 5 {
        assert!(run.try_wait().expect("a process").is_none(), "it is still at work");
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().expect("killed");
    run.wait().expect("it ends");
    let finished = made();
    assert!((5..ROWS).contains(&finished.len()), "killed in the middle: {}", finished.len());
    // As if it had been killed while it wrote, too.
    let begun = format!(".view{:06}.exr.4-0.part", ROWS - 1);
    std::fs::write(at.join(&begun), "half").expect("written");
    let changed = |name: &String| -> SystemTime {
        std::fs::metadata(at.join(name)).and_then(|file| file.modified()).expect("a time")
    };
    let before: Vec<_> = finished.iter().map(changed).collect();
    let text = succeed(folder.path(), &arguments(&[&NOISE, &slow], "killed"));
    let rest = format!("{} view(s), {} finished before", ROWS - finished.len(), finished.len());
    assert!(text.contains(&rest), "{rest}: {text}");
    assert!(finished.iter().map(changed).eq(before), "what was finished is as it was");
    assert_same(&all(&folder, "killed"), &all(&folder, "whole"));
}

#[test]
fn views_of_something_else_are_not_replaced() {
    let folder = write_inputs();
    write(&folder, "views.csv", &table(3));
    succeed(folder.path(), &arguments(&[], "out"));
    let before = all(&folder, "out");
    let mut hu = bytes(folder.path(), "ct.raw");
    hu[2 * 4321] ^= 1;
    std::fs::write(folder.path().join("ct2.raw"), hu).expect("written");
    let other_ct: Vec<_> =
        arguments(&[], "out").iter().map(|&a| if a == "ct.raw" { "ct2.raw" } else { a }).collect();
    let cases = [
        (
            "made_of.json: its views have spectrum \"W120_2p5Al\", but here it is \"W80_2p5Al\"",
            arguments(&[&["--spectrum", "W80_2p5Al"]], "out"),
        ),
        (
            "its views have algorithm \"joseph\", but here it is \"siddon\"",
            arguments(&[&["--algorithm", "siddon"]], "out"),
        ),
        (
            "its views have layers \"intensity, line_integral\"",
            arguments(&[&["--layers", "line_integral"]], "out"),
        ),
        ("its views have effects \"none\"", arguments(&[&NOISE], "out")),
        ("its views have another CT, or other labels", other_ct.clone()),
    ];
    for (words, arguments) in cases {
        let error = refused(&folder, &arguments);
        assert!(error.contains(words) && error.contains("valid: another folder"), "{words}: {error}");
    }
    // More rows are no other views; a row that is another is.
    write(&folder, "views.csv", &table(5));
    let more = succeed(folder.path(), &arguments(&[], "out"));
    assert!(more.contains("2 view(s), 3 finished before"), "{more}");
    write(&folder, "views.csv", &table(5).replace("\n3.7,", "\n3.75,"));
    let error = refused(&folder, &arguments(&[], "out"));
    assert!(
        error.contains("view000001.exr has source \"") && error.contains("in row 1 of --views it is"),
        "{error}"
    );
    // A view says it itself.
    write(&folder, "views.csv", &table(5));
    std::fs::remove_file(folder.path().join("out/made_of.json")).expect("removed");
    let error = refused(&folder, &other_ct);
    assert!(error.contains("view000000.exr has another CT"), "{error}");
    let after = all(&folder, "out");
    assert!(!after.contains_key("made_of.json"), "a refused call says nothing about the folder");
    assert!(before.iter().all(|(name, bytes)| is(name, "json") || after[name] == *bytes));
}

#[test]
fn raw_layers_that_were_not_asked_for_then_are_made() {
    let folder = write_inputs();
    write(&folder, "views.csv", &table(2));
    let reference = ["--engine", "reference", "--layers", "intensity,intensity"];
    succeed(folder.path(), &arguments(&[&reference], "out"));
    let text = succeed(folder.path(), &arguments(&[&reference, &["--raw"]], "out"));
    assert!(text.contains("2 view(s), 0 finished before"), "{text}");
    let raw = |n: usize| format!("view00000{n}_intensity.f64");
    assert!(
        [0, 1]
            .iter()
            .all(|&n| f64s(&folder.path().join("out"), &raw(n)).iter().any(|&x| f64::from(x as f32) != x))
    );
    let text = succeed(folder.path(), &arguments(&[&reference, &["--raw"]], "out"));
    assert!(text.contains("0 view(s), 2 finished before"), "{text}");
}

#[test]
fn what_is_wrong_with_a_table_or_a_shard_is_named() {
    let folder = write_inputs();
    write(&folder, "views.csv", "angle_degrees,sad_mm\n0,1000\n0,-1\n");
    let one = ["project", "--views", "views.csv"];
    let cases = [
        (vec![], "--views: views.csv: line 3: sad_mm is \"-1\"; valid: a number above 0"),
        (vec!["--shard", "0/2"], "--shard"),
        (vec!["--shard", "3/2"], "with I from 1 to N"),
        (vec!["--angles", "3"], "--angles"),
        (vec!["--geometry", "g.json"], "--geometry"),
        (vec!["--first-view", "-1"], "--first-view"),
    ];
    for (others, words) in cases {
        let error = refused(&folder, &[&one[..], &others].concat());
        assert!(error.contains(words), "{words}: {error}");
    }
    assert!(refused(&folder, &["project", "--shard", "1/2"]).contains("--views"));
    assert!(refused(&folder, &["project", "--views", "none.csv"]).contains("none.csv"));
}

/// The most memory that a run had, bytes.
#[cfg(target_os = "linux")]
fn peak(folder: &TempDir, rows: usize) -> usize {
    write(folder, "views.csv", &table(rows));
    let output = rows.to_string();
    let own = [
        "project",
        "--views",
        "views.csv",
        "--no-check",
        "--output",
        &output,
        "--size",
        "128x128",
        "--threads",
        "2",
    ];
    let mut run = start(folder, &[&own[..], &RAW].concat());
    let status = format!("/proc/{}/status", run.id());
    let mut peak = 0;
    while run.try_wait().expect("a process").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
        peak = line.map_or(peak, |kibibytes| 1024 * kibibytes.parse::<usize>().expect("a number"));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_eq!(files(&folder.path().join(output)).len(), rows + 2);
    peak
}

#[test]
#[cfg(target_os = "linux")]
fn memory_does_not_grow_with_the_number_of_views() {
    let folder = write_inputs();
    let [few, many] = [50, 400].map(|rows| peak(&folder, rows));
    let images = (400 - 50) * 2 * 128 * 128 * size_of::<f32>();
    assert!(few > 1 << 20 && many < few + images / 10, "{few} {many}: {images} more of images");
}
