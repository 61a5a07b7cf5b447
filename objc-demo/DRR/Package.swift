// swift-tools-version:5.9
// The library as a Swift package: objc-demo/xcframework.sh puts DRR.xcframework beside a copy of this file.
import PackageDescription

let package = Package(
    name: "DRR",
    platforms: [.macOS(.v13)],
    products: [.library(name: "DRR", targets: ["DRR"])],
    targets: [.binaryTarget(name: "DRR", path: "DRR.xcframework")]
)
