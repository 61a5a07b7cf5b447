#import "DRRRenderer.h"

#import "DRRDisplay.h"
#import "DRRFailure.h"
#import "DRRMetalPair.h"

@implementation DRRRenderer {
    DRRMetalPair *_pair;
    CAMetalLayer *_layer;
    DRRDisplay *_display;
    id<MTLCommandQueue> _commands;
    dispatch_queue_t _worker; // projects, so that the main thread stays free
    DRRShot *_projected;      // what the pair's buffer holds; of the worker
    // Of the main thread: what waits, and whether anything is under way.
    dispatch_block_t _waiting;
    BOOL _busy;
}

- (nullable instancetype)initWithPair:(DRRMetalPair *)pair layer:(CAMetalLayer *)layer error:(NSError **)error {
    if ((self = [super init]) == nil) return nil;
    _pair = pair;
    _layer = layer;
    _display = [[DRRDisplay alloc] initWithDevice:pair.device error:error];
    _commands = [pair.device newCommandQueue];
    _worker = dispatch_queue_create("org.drr.demo.render", DISPATCH_QUEUE_SERIAL);
    return _display == nil ? nil : self;
}

- (void)show:(DRRShot *)shot window:(float)window level:(float)level {
    const dispatch_block_t request = ^{ [self render:shot window:window level:level]; };
    _waiting = request; /* given up as soon as it starts */
    [self startWaiting];
}

- (void)startWaiting {
    if (_busy || _waiting == nil) return;
    _busy = YES;
    dispatch_async(_worker, _waiting);
    _waiting = nil;
}

- (void)finishedAfter:(NSTimeInterval)all gpu:(NSTimeInterval)gpu error:(nullable NSError *)error {
    dispatch_async(dispatch_get_main_queue(), ^{
        self->_busy = NO;
        if (self.shown != nil) self.shown(gpu, all, error);
        [self startWaiting];
    });
}

// Nothing else uses the pair's buffer now: the last request's command buffer has completed.
- (BOOL)project:(DRRShot *)shot commands:(id<MTLCommandBuffer>)commands error:(NSError **)error {
    if (shot == _projected) return YES;
    _projected = nil;
    const BOOL plain = shot.effects.names.count == 0;
    if (plain ? ![_pair encode:shot into:commands error:error] : ![_pair develop:shot error:error]) return NO;
    _projected = shot;
    return YES;
}

- (void)render:(DRRShot *)shot window:(float)window level:(float)level {
    @autoreleasepool {
        const NSTimeInterval start = NSDate.timeIntervalSinceReferenceDate;
        const id<MTLCommandBuffer> commands = [_commands commandBuffer];
        NSError *error = nil;
        BOOL done = commands != nil && [self project:shot commands:commands error:&error];
        const id<CAMetalDrawable> drawable = done ? [_layer nextDrawable] : nil;
        done = drawable != nil && [_display show:_pair.intensity
                                            size:_pair.size
                                          window:window
                                           level:level
                                              on:drawable.texture
                                        commands:commands
                                           error:&error];
        if (!done) {
            _projected = nil; /* what was encoded is not run */
            if (error == nil) DRRFail((NSInteger)DRR_STATUS_DEVICE, @"Metal has no command buffer or drawable", &error);
            [self finishedAfter:NSDate.timeIntervalSinceReferenceDate - start gpu:0 error:error];
            return;
        }
        [commands presentDrawable:drawable];
        [commands addCompletedHandler:^(id<MTLCommandBuffer> completed) {
            [self finishedAfter:NSDate.timeIntervalSinceReferenceDate - start
                            gpu:completed.GPUEndTime - completed.GPUStartTime
                          error:completed.error];
        }];
        [commands commit];
    }
}

@end
