# The version of the header beside which this file was installed. Before 1.0 a minor version may break what came before.
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/../../../include/drr/DRR_Shared.h" drr_version REGEX "^#define DRR_VERSION_")
list(TRANSFORM drr_version REPLACE "^#define DRR_VERSION_[A-Z]+ " "")
list(JOIN drr_version "." PACKAGE_VERSION)
list(GET drr_version 0 drr_major)
list(GET drr_version 1 drr_minor)

set(PACKAGE_VERSION_COMPATIBLE FALSE)
if(PACKAGE_FIND_VERSION_RANGE)
    if(PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION_MIN
       AND (PACKAGE_VERSION VERSION_LESS PACKAGE_FIND_VERSION_MAX
            OR (PACKAGE_FIND_VERSION_RANGE_MAX STREQUAL "INCLUDE"
                AND PACKAGE_VERSION VERSION_EQUAL PACKAGE_FIND_VERSION_MAX)))
        set(PACKAGE_VERSION_COMPATIBLE TRUE)
    endif()
elseif(PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION
       AND drr_major EQUAL PACKAGE_FIND_VERSION_MAJOR
       AND (drr_major GREATER 0 OR PACKAGE_FIND_VERSION_COUNT EQUAL 1 OR drr_minor EQUAL PACKAGE_FIND_VERSION_MINOR))
    set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
if(PACKAGE_VERSION VERSION_EQUAL PACKAGE_FIND_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
endif()
unset(drr_version)
unset(drr_major)
unset(drr_minor)
