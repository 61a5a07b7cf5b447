//! The README shows the program that is tested.
#![allow(missing_docs, reason = "a test program")]

#[test]
fn the_c_program_is_minimal_c() {
    let readme = include_str!("../README.md");
    let program = include_str!("../cabi-tests/minimal.c");
    let shown =
        readme.split_once("```c\n").and_then(|(_, rest)| rest.split_once("```")).map(|(code, _)| code);
    assert_eq!(shown, Some(program), "copy cabi-tests/minimal.c into the README");
}

#[test]
fn what_it_links_to_exists() {
    let readme = include_str!("../README.md");
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let links: Vec<_> =
        readme.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link).collect();
    assert!(links.len() > 3);
    for link in links {
        assert!(root.join(link).exists(), "{link} is not there");
    }
}
