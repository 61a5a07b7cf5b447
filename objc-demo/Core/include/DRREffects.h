// Effects of a real exposure, each on or off, with typical parameters.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

@interface DRREffects : NSObject {
  @private
    NSSet *_names;
}

// All there are, in the order in which a photon meets them.
+ (NSArray *)allNames;
// What an effect does, in a few words.
+ (NSString *)titleOf:(NSString *)name;

// Those with these names. nil with an error that lists all names when one is unknown.
- (instancetype)initWithNames:(NSArray *)names error:(NSError **)error;

// The names of those that are on, in order.
@property (nonatomic, readonly) NSArray *names;
// Those that decide which rays are cast: of the others an exposure's rays can be developed again.
@property (nonatomic, readonly) BOOL moveRays;

// Switches them on in a scene, which points to tables that are always there.
- (void)addTo:(DrrScene *)scene;

@end
