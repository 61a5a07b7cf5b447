#!/usr/bin/env bash
# Makes DRR.xcframework, for Macs with arm64 and x86_64, and a Swift package of it, in a folder: target/swift/DRR, or the one
# given. Needs macOS, Xcode and rustup.
#
#   objc-demo/xcframework.sh [FOLDER]
set -euo pipefail

if [ "$(uname -s)" != Darwin ]; then
    echo "xcframework.sh: needs macOS, where xcodebuild and lipo are; this is $(uname -s)" >&2
    exit 1
fi
root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/target/swift/DRR}
mkdir -p "$out"
out=$(cd "$out" && pwd)
cd "$root"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export MACOSX_DEPLOYMENT_TARGET=13.0
slices=()
for target in aarch64-apple-darwin x86_64-apple-darwin; do
    rustup target add "$target"
    cargo build --release --locked --lib --no-default-features --features dicom --target "$target" --target-dir "$work/$target"
    slices+=("$work/$target/$target/release/libdrr.dylib")
done
# build.rs has named it @rpath/libdrr.dylib.
lipo -create "${slices[@]}" -output "$work/libdrr.dylib"
mkdir "$work/include"
cp include/DRR_Shared.h include/drr.hpp include/module.modulemap "$work/include/"

rm -rf "$out/DRR.xcframework"
xcodebuild -create-xcframework -library "$work/libdrr.dylib" -headers "$work/include" -output "$out/DRR.xcframework"
cp objc-demo/DRR/Package.swift "$out/"
echo "$out"
