#import "DRRApp.h"

#import <Metal/Metal.h>

#import "DRREngine.h"
#import "DRRFailure.h"
#import "DRRPhantom.h"
#import "DRRScan+Texture.h"
#import "DRRViewer.h"

@implementation DRRApp {
    id<MTLDevice> _device;
    DRREngine *_engine;
    DRRViewer *_viewer;
}

- (void)applicationDidFinishLaunching:(NSNotification *)notification {
    (void)notification;
    [self makeMenu];
    NSError *error = nil;
    _device = MTLCreateSystemDefaultDevice();
    if (_device == nil) DRRFail((NSInteger)DRR_STATUS_UNSUPPORTED, @"this Mac has no GPU that Metal can use", &error);
    else _engine = [[DRREngine alloc] initWithMetalDevice:_device error:&error];
    DRRScan *const scan = _engine == nil ? nil : [self phantom:&error];
    if (scan == nil || ![self view:scan title:@"Phantom" error:&error]) {
        [[NSAlert alertWithError:error] runModal];
        [NSApp terminate:nil];
    }
}

- (BOOL)applicationShouldTerminateAfterLastWindowClosed:(NSApplication *)application {
    (void)application;
    return YES;
}

- (void)makeMenu {
    NSMenu *const bar = [[NSMenu alloc] initWithTitle:@""], *const menu = [[NSMenu alloc] initWithTitle:@""];
    [menu addItemWithTitle:@"Open CT…" action:@selector(openDocument:) keyEquivalent:@"o"];
    [menu addItemWithTitle:@"Quit" action:@selector(terminate:) keyEquivalent:@"q"];
    NSMenuItem *const item = [bar addItemWithTitle:@"" action:NULL keyEquivalent:@""];
    item.submenu = menu;
    NSApp.mainMenu = bar;
}

// The phantom's voxels go to a texture of ours, which the library reads.
- (nullable DRRScan *)phantom:(NSError **)error {
    DRRPhantom *const phantom = [[DRRPhantom alloc] initWithSpacing:1];
    const id<MTLTexture> texture = phantom == nil ? nil : [DRRScan textureOf:phantom device:_device];
    if (texture != nil) return [[DRRScan alloc] initWithTexture:texture descriptor:phantom.descriptor engine:_engine error:error];
    DRRFail((NSInteger)DRR_STATUS_OUT_OF_MEMORY, @"no memory for the phantom", error);
    return nil;
}

- (BOOL)view:(DRRScan *)scan title:(NSString *)title error:(NSError **)error {
    DRRViewer *const viewer = [[DRRViewer alloc] initWithScan:scan device:_device title:title error:error];
    if (viewer == nil) return NO;
    [viewer.window makeKeyAndOrderFront:nil];
    [_viewer.window close];
    _viewer = viewer;
    return YES;
}

// A file that the user chooses may be read, in a sandbox too.
- (void)openDocument:(id)sender {
    (void)sender;
    NSOpenPanel *const panel = [NSOpenPanel openPanel];
    panel.canChooseDirectories = YES;
    if ([panel runModal] != NSModalResponseOK) return;
    NSError *error = nil;
    NSURL *const url = panel.URL;
    DRRScan *const scan = [[DRRScan alloc] initWithPath:url.path engine:_engine error:&error];
    if (scan == nil || ![self view:scan title:url.lastPathComponent error:&error]) [[NSAlert alertWithError:error] runModal];
}

@end
