#import "DRRViewer.h"

#import "DRRControls.h"
#import "DRREffectCosts.h"
#import "DRRMetalPair.h"
#import "DRRPicture.h"
#import "DRRRenderer.h"
#import "DRRScan.h"
#import "DRRStereoPair.h"
#import "DRRStereoView.h"

enum { PIXELS = 720 };

@implementation DRRViewer {
    DRRScan *_scan;
    DRRMetalPair *_pair;
    DRRRenderer *_renderer;
    DRRControls *_controls;
    DRRShot *_shot;
}

- (nullable instancetype)initWithScan:(DRRScan *)scan
                               device:(id<MTLDevice>)device
                                title:(NSString *)title
                                error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _scan = scan;
    _controls = [DRRControls controls];
    _pair = [[DRRMetalPair alloc] initWithScan:scan device:device size:PIXELS error:error];
    DRRStereoView *const view = [[DRRStereoView alloc] initWithDevice:device size:PIXELS];
    if (_pair == nil) return nil;
    _renderer = [[DRRRenderer alloc] initWithPair:_pair layer:view.metalLayer error:error];
    if (_renderer == nil || ![self chooseWindow:error]) return nil;

    NSStackView *const content = [NSStackView stackViewWithViews:@[ view, _controls ]];
    content.orientation = NSUserInterfaceLayoutOrientationHorizontal;
    content.distribution = NSStackViewDistributionFill;
    [view.widthAnchor constraintGreaterThanOrEqualToConstant:600].active = YES;
    [view.heightAnchor constraintEqualToAnchor:content.heightAnchor].active = YES;
    [_controls.widthAnchor constraintEqualToConstant:320].active = YES;
    _window = [[NSWindow alloc] initWithContentRect:NSMakeRect(0, 0, 1500, 620)
                                          styleMask:NSWindowStyleMaskTitled | NSWindowStyleMaskClosable |
                                                    NSWindowStyleMaskResizable | NSWindowStyleMaskMiniaturizable
                                            backing:NSBackingStoreBuffered
                                              defer:NO];
    _window.releasedWhenClosed = NO;
    _window.title = title;
    _window.contentView = content;
    [_window center];
    [self connect];
    [self measureEffects];
    return self;
}

// The shot that the controls ask for.
- (nullable DRRShot *)shotWith:(NSError **)error {
    DRREffects *const effects = [[DRREffects alloc] initWithNames:_controls.effects error:error];
    if (effects == nil) return nil;
    return [[DRRShot alloc] initWithAngle:_controls.angle kvp:_controls.kvp effects:effects size:PIXELS error:error];
}

// Window and level at first: those of the picture's own greys.
- (BOOL)chooseWindow:(NSError **)error {
    _shot = [self shotWith:error];
    if (_shot == nil || ![_pair develop:_shot error:error]) return NO;
    DRRPicture *const picture = [[DRRPicture alloc] initWithIntensity:_pair.intensity.contents
                                                                views:DRRViews
                                                                width:PIXELS
                                                               height:PIXELS];
    _controls.window = picture.window;
    _controls.level = picture.level;
    return YES;
}

- (void)connect {
    __weak DRRViewer *const viewer = self;
    _controls.changed = ^(BOOL shot) { [viewer changed:shot]; };
    _renderer.shown = ^(NSTimeInterval gpu, NSTimeInterval all, NSError *error) {
        [viewer shownAfter:all gpu:gpu error:error];
    };
    [self changed:NO];
}

- (void)changed:(BOOL)shot {
    NSError *error = nil;
    DRRShot *const wanted = shot ? [self shotWith:&error] : _shot;
    if (wanted == nil) {
        _controls.status = error.localizedDescription;
        return;
    }
    _shot = wanted;
    [_renderer show:_shot window:(float)_controls.window level:(float)_controls.level];
}

- (void)shownAfter:(NSTimeInterval)all gpu:(NSTimeInterval)gpu error:(nullable NSError *)error {
    _controls.status = error != nil ? error.localizedDescription
                                    : [NSString stringWithFormat:@"GPU %.2f ms, in all %.1f ms", 1e3 * gpu, 1e3 * all];
}

// Once, beside the display: on a pair of its own, because a pair is one thread's.
- (void)measureEffects {
    DRRScan *const scan = _scan;
    DRRShot *const shot = _shot;
    __weak DRRViewer *const viewer = self;
    dispatch_async(dispatch_get_global_queue(QOS_CLASS_UTILITY, 0), ^{
        DRRStereoPair *const pair = [[DRRStereoPair alloc] initWithScan:scan];
        NSDictionary *const costs = DRREffectCosts(pair, shot, DRREffects.allNames, 5, NULL);
        dispatch_async(dispatch_get_main_queue(), ^{
            DRRViewer *const alive = viewer;
            if (alive != nil && costs != nil) [alive->_controls showCosts:costs];
        });
    });
}

@end
