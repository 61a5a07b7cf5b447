// What each effect costs here, measured: the time of a shot with it, less that of the same shot without any.
#import <Foundation/Foundation.h>

@class DRRShot, DRRStereoPair;

// Seconds by name (NSNumber by NSString) for `names`, in shots that are otherwise like `shot`: medians of `runs`. A focal spot
// is charged for its rays, what is developed from the same rays for its development. nil with an error.
NSDictionary *DRREffectCosts(DRRStereoPair *pair, DRRShot *shot, NSArray *names, NSUInteger runs, NSError **error);
