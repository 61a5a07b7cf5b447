#import "DRRFailure.h"

NSString *const DRRErrorDomain = @"org.drr.demo";

BOOL DRRSucceeds(DrrStatus status, NSError **error) {
    if (status == DRR_STATUS_OK) return YES;
    NSString *message = [NSString stringWithUTF8String:drr_last_error_message()];
    return DRRFail((NSInteger)status, message, error);
}

BOOL DRRFail(NSInteger code, NSString *message, NSError **error) {
    if (error != NULL) {
        NSDictionary *const text = [NSDictionary dictionaryWithObject:message forKey:NSLocalizedDescriptionKey];
        *error = [NSError errorWithDomain:DRRErrorDomain code:code userInfo:text];
    }
    return NO;
}
