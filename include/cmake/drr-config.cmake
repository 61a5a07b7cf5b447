# find_package(drr 0.1 CONFIG REQUIRED), then target_link_libraries(program PRIVATE drr::drr), or drr::drr_static.
#
# All paths are relative to this file: the folder that the package was installed into may be moved. On macOS the library itself
# names the folder that it was installed to; install_name_tool -id changes that.
if(CMAKE_VERSION VERSION_LESS 3.21)
    set(drr_FOUND FALSE)
    set(drr_NOT_FOUND_MESSAGE "drr needs CMake 3.21 or later")
    return()
endif()

get_filename_component(drr_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(drr_places HINTS "${drr_prefix}" PATH_SUFFIXES lib lib64 "lib/${CMAKE_LIBRARY_ARCHITECTURE}" NO_DEFAULT_PATH NO_CACHE)
find_library(drr_shared NAMES "${CMAKE_SHARED_LIBRARY_PREFIX}drr${CMAKE_SHARED_LIBRARY_SUFFIX}" ${drr_places})
find_library(drr_static NAMES libdrr.a ${drr_places})
find_file(drr_pc NAMES pkgconfig/drr.pc ${drr_places})

if(drr_shared AND NOT TARGET drr::drr)
    add_library(drr::drr SHARED IMPORTED)
    set_target_properties(drr::drr PROPERTIES
        IMPORTED_LOCATION "${drr_shared}"
        INTERFACE_INCLUDE_DIRECTORIES "${drr_prefix}/include/drr")
endif()
if(drr_static AND drr_pc AND NOT TARGET drr::drr_static)
    # What Rust's standard library needs of the system is what drr.pc says.
    file(STRINGS "${drr_pc}" drr_private REGEX "^Libs.private:")
    string(REGEX REPLACE "^Libs.private:" "" drr_private "${drr_private}")
    string(REGEX MATCHALL "-framework +[^ ]+|[^ ]+" drr_private "${drr_private}")
    add_library(drr::drr_static STATIC IMPORTED)
    set_target_properties(drr::drr_static PROPERTIES
        IMPORTED_LOCATION "${drr_static}"
        INTERFACE_INCLUDE_DIRECTORIES "${drr_prefix}/include/drr"
        INTERFACE_LINK_LIBRARIES "${drr_private}")
    unset(drr_private)
endif()

if(NOT drr_shared AND NOT drr_static)
    set(drr_FOUND FALSE)
    set(drr_NOT_FOUND_MESSAGE "no library of drr below ${drr_prefix}")
endif()
unset(drr_shared)
unset(drr_static)
unset(drr_pc)
unset(drr_places)
unset(drr_prefix)
