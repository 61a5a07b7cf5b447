// Stand-in, see ../README.md.
#pragma once
#import <Foundation/Foundation.h>

NS_ASSUME_NONNULL_BEGIN

typedef NS_ENUM(NSInteger, XCTAttachmentLifetime) { XCTAttachmentLifetimeKeepAlways };

@interface XCTAttachment : NSObject
@property XCTAttachmentLifetime lifetime;
+ (instancetype)attachmentWithString:(NSString *)string;
@end

@interface XCTestCase : NSObject
- (BOOL)setUpWithError:(NSError *_Nullable *_Nullable)error;
- (void)addAttachment:(XCTAttachment *)attachment;
@end

// Each takes an optional format with arguments. Values are compared as scalars.
void drr_stand_in_record(XCTestCase *test, BOOL held, NSString *_Nullable format, ...) NS_FORMAT_FUNCTION(3, 4);
#define DRR_STAND_IN_RECORD(held, ...) drr_stand_in_record(self, (held), @"" __VA_ARGS__)
#define XCTAssertTrue(value, ...) DRR_STAND_IN_RECORD(value, __VA_ARGS__)
#define XCTAssertNil(value, ...) DRR_STAND_IN_RECORD((value) == nil, __VA_ARGS__)
#define XCTAssertNotNil(value, ...) DRR_STAND_IN_RECORD((value) != nil, __VA_ARGS__)
#define XCTAssertEqual(a, b, ...) DRR_STAND_IN_RECORD((a) == (b), __VA_ARGS__)
#define XCTAssertGreaterThan(a, b, ...) DRR_STAND_IN_RECORD((a) > (b), __VA_ARGS__)
#define XCTAssertLessThanOrEqual(a, b, ...) DRR_STAND_IN_RECORD((a) <= (b), __VA_ARGS__)
#define XCTSkipIf(condition, ...) DRR_STAND_IN_RECORD(!(condition), __VA_ARGS__)

NS_ASSUME_NONNULL_END
