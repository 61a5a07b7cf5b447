// As Swift and Objective-C import the library: by include/module.modulemap.
@import DRR;

int main(void) { return drr_version() == NULL; }
