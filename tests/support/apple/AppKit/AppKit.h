// Stand-in, see ../README.md.
#pragma once
#import <Foundation/Foundation.h>
#import <QuartzCore/CAMetalLayer.h>

NS_ASSUME_NONNULL_BEGIN

@class NSApplication, NSMenu, NSMenuItem, NSTextField, NSWindow;
typedef struct {
    CGFloat top, left, bottom, right;
} NSEdgeInsets;
static inline NSEdgeInsets NSEdgeInsetsMake(CGFloat top, CGFloat left, CGFloat bottom, CGFloat right) {
    return (NSEdgeInsets){top, left, bottom, right};
}
static const NSRect NSZeroRect = {{0, 0}, {0, 0}};
typedef NSInteger NSModalResponse;
static const NSModalResponse NSModalResponseOK = 1;
typedef NS_OPTIONS(NSUInteger, NSWindowStyleMask) {
    NSWindowStyleMaskTitled = 1,
    NSWindowStyleMaskClosable = 2,
    NSWindowStyleMaskMiniaturizable = 4,
    NSWindowStyleMaskResizable = 8,
};
typedef NS_ENUM(NSUInteger, NSBackingStoreType) { NSBackingStoreBuffered = 2 };
typedef NS_ENUM(NSInteger, NSApplicationActivationPolicy) { NSApplicationActivationPolicyRegular };
typedef NS_ENUM(NSInteger, NSUserInterfaceLayoutOrientation) {
    NSUserInterfaceLayoutOrientationHorizontal = 0,
    NSUserInterfaceLayoutOrientationVertical = 1,
};
typedef NS_ENUM(NSInteger, NSLayoutAttribute) { NSLayoutAttributeLeading = 5 };
typedef NSInteger NSControlStateValue;
static const NSControlStateValue NSControlStateValueOn = 1;

typedef NS_ENUM(NSInteger, NSStackViewDistribution) { NSStackViewDistributionFill = 0 };
typedef NS_ENUM(NSInteger, NSViewLayerContentsRedrawPolicy) { NSViewLayerContentsRedrawNever = 0 };
typedef NS_ENUM(NSInteger, NSViewLayerContentsPlacement) { NSViewLayerContentsPlacementScaleProportionallyToFit = 1 };

@interface NSLayoutConstraint : NSObject
@property (getter=isActive) BOOL active;
@end

@interface NSLayoutDimension : NSObject
- (NSLayoutConstraint *)constraintEqualToConstant:(CGFloat)constant;
- (NSLayoutConstraint *)constraintEqualToAnchor:(NSLayoutDimension *)anchor;
- (NSLayoutConstraint *)constraintGreaterThanOrEqualToConstant:(CGFloat)constant;
@end

@interface NSResponder : NSObject
@end

@interface NSView : NSResponder
@property BOOL wantsLayer;
@property (nullable, copy) NSString *toolTip;
@property (readonly, strong) NSLayoutDimension *widthAnchor;
@property (readonly, strong) NSLayoutDimension *heightAnchor;
@property NSViewLayerContentsRedrawPolicy layerContentsRedrawPolicy;
@property NSViewLayerContentsPlacement layerContentsPlacement;
- (CALayer *)makeBackingLayer;
- (instancetype)initWithFrame:(NSRect)frame;
@end

@interface NSStackView : NSView
@property NSUserInterfaceLayoutOrientation orientation;
@property NSStackViewDistribution distribution;
@property NSLayoutAttribute alignment;
@property NSEdgeInsets edgeInsets;
+ (instancetype)stackViewWithViews:(NSArray<NSView *> *)views;
- (void)addArrangedSubview:(NSView *)view;
@end

@interface NSControl : NSView
@property double doubleValue;
@property (copy) NSString *stringValue;
@property (getter=isContinuous) BOOL continuous;
@end

@interface NSSlider : NSControl
@property NSInteger numberOfTickMarks;
@property BOOL allowsTickMarkValuesOnly;
+ (instancetype)sliderWithValue:(double)value
                       minValue:(double)minValue
                       maxValue:(double)maxValue
                         target:(nullable id)target
                         action:(nullable SEL)action;
@end

@interface NSButton : NSControl
@property (copy) NSString *title;
@property NSControlStateValue state;
+ (instancetype)checkboxWithTitle:(NSString *)title target:(nullable id)target action:(nullable SEL)action;
@end

@interface NSTextField : NSControl
+ (instancetype)labelWithString:(NSString *)string;
@end

@interface NSWindow : NSResponder
@property (copy) NSString *title;
@property (nullable, strong) NSView *contentView;
@property (getter=isReleasedWhenClosed) BOOL releasedWhenClosed;
- (instancetype)initWithContentRect:(NSRect)contentRect
                          styleMask:(NSWindowStyleMask)style
                            backing:(NSBackingStoreType)backing
                              defer:(BOOL)defer;
- (void)center;
- (void)close;
- (void)makeKeyAndOrderFront:(nullable id)sender;
@end

@interface NSOpenPanel : NSWindow
@property (nullable, readonly, copy) NSURL *URL;
@property BOOL canChooseDirectories;
+ (NSOpenPanel *)openPanel;
- (NSModalResponse)runModal;
@end

@interface NSAlert : NSObject
+ (NSAlert *)alertWithError:(NSError *)error;
- (NSModalResponse)runModal;
@end

@interface NSMenuItem : NSObject
@property (nullable, strong) NSMenu *submenu;
@end

@interface NSMenu : NSObject
- (instancetype)initWithTitle:(NSString *)title;
- (NSMenuItem *)addItemWithTitle:(NSString *)title action:(nullable SEL)selector keyEquivalent:(NSString *)key;
@end

@protocol NSApplicationDelegate <NSObject>
@optional
- (void)applicationDidFinishLaunching:(NSNotification *)notification;
- (BOOL)applicationShouldTerminateAfterLastWindowClosed:(NSApplication *)sender;
@end

@interface NSApplication : NSResponder
@property (class, readonly, strong) NSApplication *sharedApplication;
@property (nullable, weak) id<NSApplicationDelegate> delegate;
@property (nullable, strong) NSMenu *mainMenu;
- (BOOL)setActivationPolicy:(NSApplicationActivationPolicy)policy;
- (void)run;
- (void)terminate:(nullable id)sender;
@end

extern __kindof NSApplication *_Null_unspecified NSApp;

NS_ASSUME_NONNULL_END
