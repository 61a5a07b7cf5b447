// Failures as NSError.
#import <Foundation/Foundation.h>

#import "DRR_Shared.h"

// Codes of this domain are the library's statuses, or one of the demo's own below.
extern NSString *const DRRErrorDomain;

enum {
    DRRErrorArgument = -1, // the message names it, its value and what is valid
    DRRErrorFile = -2,     // the message names it
};

// Whether a call of the library succeeded. If not, and `error` is not NULL, *error has the status as its code and
// drr_last_error_message() of this thread as its text: call it at once, on the thread that made the call.
BOOL DRRSucceeds(DrrStatus status, NSError **error);

// Always NO, with an error of the demo's own.
BOOL DRRFail(NSInteger code, NSString *message, NSError **error);
