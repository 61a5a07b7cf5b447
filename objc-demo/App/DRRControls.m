#import "DRRControls.h"

#include <math.h>

#import "DRRShot.h"

@implementation DRRControls {
    NSSlider *_angle, *_kvp, *_window, *_level;
    NSArray<NSButton *> *_boxes; // in the order of DRREffects.allNames
    NSTextField *_status;
}

+ (instancetype)controls {
    DRRControls *const controls = [[self alloc] initWithFrame:NSZeroRect];
    [controls fill];
    return controls;
}

- (NSSlider *)sliderFrom:(double)low to:(double)high at:(double)value title:(NSString *)title {
    NSSlider *const slider = [NSSlider sliderWithValue:value
                                              minValue:low
                                              maxValue:high
                                                target:self
                                                action:@selector(moved:)];
    slider.continuous = YES;
    NSTextField *const label = [NSTextField labelWithString:title];
    [label.widthAnchor constraintEqualToConstant:80].active = YES;
    [slider.widthAnchor constraintEqualToConstant:200].active = YES;
    NSStackView *const row = [NSStackView stackViewWithViews:@[ label, slider ]];
    [self addArrangedSubview:row];
    return slider;
}

- (void)fill {
    self.orientation = NSUserInterfaceLayoutOrientationVertical;
    self.alignment = NSLayoutAttributeLeading;
    self.edgeInsets = NSEdgeInsetsMake(12, 12, 12, 12);
    NSArray<NSNumber *> *const voltages = DRRShot.voltages;
    _angle = [self sliderFrom:0.5 to:45 at:6 title:@"Angle, °"];
    _kvp = [self sliderFrom:0 to:(double)(voltages.count - 1) at:(double)[voltages indexOfObject:@120] title:@"Tube, kV"];
    _kvp.numberOfTickMarks = (NSInteger)voltages.count;
    _kvp.allowsTickMarkValuesOnly = YES;
    _window = [self sliderFrom:0.1 to:10 at:5 title:@"Window"];
    _level = [self sliderFrom:0 to:10 at:3 title:@"Level"];
    NSMutableArray<NSButton *> *const boxes = [NSMutableArray array];
    for (NSString *name in DRREffects.allNames) {
        NSButton *const box = [NSButton checkboxWithTitle:name target:self action:@selector(moved:)];
        box.toolTip = [DRREffects titleOf:name];
        [self addArrangedSubview:box];
        [boxes addObject:box];
    }
    _boxes = boxes;
    _status = [NSTextField labelWithString:@""];
    [self addArrangedSubview:_status];
}

- (void)moved:(NSControl *)control {
    if (self.changed != nil) self.changed(control != _window && control != _level);
}

- (double)angle {
    return _angle.doubleValue;
}

- (NSUInteger)kvp {
    return [DRRShot.voltages[(NSUInteger)lround(_kvp.doubleValue)] unsignedIntegerValue];
}

- (double)window {
    return _window.doubleValue;
}

- (void)setWindow:(double)window {
    _window.doubleValue = window;
}

- (double)level {
    return _level.doubleValue;
}

- (void)setLevel:(double)level {
    _level.doubleValue = level;
}

- (NSArray<NSString *> *)effects {
    NSMutableArray<NSString *> *const names = [NSMutableArray array];
    NSArray<NSString *> *const all = DRREffects.allNames;
    for (NSUInteger n = 0; n < all.count; n++)
        if (_boxes[n].state == NSControlStateValueOn) [names addObject:all[n]];
    return names;
}

- (NSString *)status {
    return _status.stringValue;
}

- (void)setStatus:(NSString *)status {
    _status.stringValue = status;
}

- (void)showCosts:(NSDictionary<NSString *, NSNumber *> *)costs {
    NSArray<NSString *> *const all = DRREffects.allNames;
    for (NSUInteger n = 0; n < all.count; n++) {
        NSNumber *const seconds = costs[all[n]];
        if (seconds != nil) _boxes[n].title = [NSString stringWithFormat:@"%@, %.1f ms", all[n], 1e3 * seconds.doubleValue];
    }
}

@end
