// swift-tools-version: 5.7
// The demo for Xcode and `swift build`, on macOS. The library is that of DRR_PREFIX, where cargo cinstall --libdir lib put it, or the repository's:
// cargo build --release --lib --no-default-features --features dicom
import PackageDescription

let prefix = Context.environment["DRR_PREFIX"]
let include = prefix.map { $0 + "/include/drr" } ?? Context.packageDirectory + "/../include"
let library = prefix.map { $0 + "/lib" } ?? Context.packageDirectory + "/../target/release"

// Flags that name folders outside of a package are "unsafe": only the package that is built itself may have them.
let header: [CSetting] = [.unsafeFlags(["-I" + include])]
let linked: [LinkerSetting] = [
    .unsafeFlags(["-L" + library, "-Xlinker", "-rpath", "-Xlinker", library]),
    .linkedLibrary("drr"),
]

let package = Package(
    name: "DRRDemo",
    platforms: [.macOS(.v13)],
    targets: [
        .target(name: "DRRDemo", path: "Core", cSettings: header, linkerSettings: linked),
        .target(
            name: "DRRDemoMetal", dependencies: ["DRRDemo"], path: "Metal",
            resources: [.copy("Display.metal"), .copy("Denoise.metal")], cSettings: header),
        .executableTarget(name: "drr-demo", dependencies: ["DRRDemo"], path: "Command", cSettings: header),
        .executableTarget(
            name: "DRRDemoApp", dependencies: ["DRRDemo", "DRRDemoMetal"], path: "App",
            exclude: ["Info.plist"], cSettings: header),
        .testTarget(
            name: "DRRDemoTests", dependencies: ["DRRDemo", "DRRDemoMetal"], path: "Tests", cSettings: header),
    ]
)
