// The command line.
#import <Foundation/Foundation.h>

@class DRRShot;

@interface DRRArguments : NSObject {
  @private
    NSString *_ct, *_output;
    DRRShot *_shot;
    BOOL _help;
}

// The CT's file or folder; nil: the phantom.
@property (nonatomic, readonly) NSString *ct;
// The folder to write to.
@property (nonatomic, readonly) NSString *output;
@property (nonatomic, readonly) DRRShot *shot;
// Whether only the usage is asked for; nothing else is read then.
@property (nonatomic, readonly) BOOL help;

+ (NSString *)usage;

// `arguments` without the program's name. nil with an error that names the argument, its value and what is valid.
- (instancetype)initWithArguments:(NSArray *)arguments error:(NSError **)error;

@end
