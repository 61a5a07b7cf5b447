// Sliders and check boxes.
#import <AppKit/AppKit.h>

NS_ASSUME_NONNULL_BEGIN

@interface DRRControls : NSStackView

@property (nonatomic, readonly) double angle;
@property (nonatomic, readonly) NSUInteger kvp;
@property (nonatomic) double window;
@property (nonatomic) double level;
// Names of the effects that are on.
@property (nonatomic, readonly) NSArray<NSString *> *effects;
// A line below the controls.
@property (nonatomic, copy) NSString *status;
// Called while a slider is dragged and when a box is checked; `shot`: whether more than window and level has changed.
@property (nonatomic, copy, nullable) void (^changed)(BOOL shot);

+ (instancetype)controls;

// Shows what effects cost, seconds by name.
- (void)showCosts:(NSDictionary<NSString *, NSNumber *> *)costs;

@end

NS_ASSUME_NONNULL_END
