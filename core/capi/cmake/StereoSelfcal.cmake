# Builds the C library of stereo-selfcal with cargo, and imports it.
#
#   include(path/to/core/capi/cmake/StereoSelfcal.cmake)
#   stereo_selfcal_add_library(stereo_selfcal)
#   target_link_libraries(my_program PRIVATE stereo_selfcal)
#
# stereo_selfcal_add_library(NAME [RUST_TARGET TRIPLE] [CAPACITY N] [OPT size|speed | PROFILE PROFILE])
#
#   RUST_TARGET  a bare-metal target, such as thumbv7em-none-eabihf for a Cortex-M4F or -M7; default: the
#                machine that builds.
#   CAPACITY     correspondences a pair: 64, 128, 256 (the default), 512 or 1024.
#   OPT          builds with link-time optimisation, for size or for speed; default: cargo's release profile.
#   PROFILE      a profile of Cargo.toml by its name: release, controller, controller-size.
#
# Cargo's files go to the build folder, or to STEREO_SELFCAL_TARGET_DIR. Each build folder has one capacity
# and one target.

set(STEREO_SELFCAL_CAPI "${CMAKE_CURRENT_LIST_DIR}/.." CACHE INTERNAL "")
set(STEREO_SELFCAL_TARGET_DIR "${CMAKE_BINARY_DIR}/cargo" CACHE PATH "Where cargo puts its files")

function(stereo_selfcal_add_library name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "RUST_TARGET;CAPACITY;OPT;PROFILE" "")
    if(DEFINED arg_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "stereo_selfcal_add_library: unknown arguments '${arg_UNPARSED_ARGUMENTS}'")
    endif()

    set(features)
    set(definitions)
    if(DEFINED arg_CAPACITY AND NOT arg_CAPACITY EQUAL 256)
        if(NOT arg_CAPACITY MATCHES "^(64|128|512|1024)$")
            message(FATAL_ERROR "stereo_selfcal_add_library: no capacity of ${arg_CAPACITY}")
        endif()
        set(features --features "capacity-${arg_CAPACITY}")
        set(definitions "SELFCAL_CAPACITY_${arg_CAPACITY}")
    endif()

    set(profile release)
    if(DEFINED arg_OPT AND DEFINED arg_PROFILE)
        message(FATAL_ERROR "stereo_selfcal_add_library: OPT or PROFILE, not both")
    elseif(DEFINED arg_PROFILE)
        if(NOT arg_PROFILE MATCHES "^[a-z][a-z0-9-]*$" OR arg_PROFILE STREQUAL "dev")
            message(FATAL_ERROR "stereo_selfcal_add_library: no release profile '${arg_PROFILE}'")
        endif()
        set(profile "${arg_PROFILE}")
    elseif(arg_OPT STREQUAL "size")
        set(profile controller-size)
    elseif(arg_OPT STREQUAL "speed")
        set(profile controller)
    elseif(DEFINED arg_OPT)
        message(FATAL_ERROR "stereo_selfcal_add_library: OPT is size or speed, not '${arg_OPT}'")
    endif()

    get_filename_component(capi "${STEREO_SELFCAL_CAPI}" REALPATH)
    get_filename_component(root "${capi}/../.." REALPATH)
    set(what --profile ${profile} --package stereo-selfcal-capi ${features} --crate-type staticlib)
    if(DEFINED arg_RUST_TARGET)
        set(build "${root}/.cargo/for-target" ${arg_RUST_TARGET} rustc ${what})
    else()
        set(build cargo rustc --locked ${what})
    endif()

    # Always runs: cargo tracks changes.
    set(library "${CMAKE_BINARY_DIR}/libstereo_selfcal.a")
    add_custom_target(${name}_build
        COMMAND ${CMAKE_COMMAND} -E env "CARGO_TARGET_DIR=${STEREO_SELFCAL_TARGET_DIR}" ${build}
        COMMAND ${CMAKE_COMMAND}
            "-DFROM=${STEREO_SELFCAL_TARGET_DIR}" "-DTARGET=${arg_RUST_TARGET}" "-DPROFILE=${profile}" "-DTO=${library}"
            -P "${capi}/cmake/take_library.cmake"
        WORKING_DIRECTORY "${root}"
        BYPRODUCTS "${library}"
        USES_TERMINAL VERBATIM)

    add_library(${name} STATIC IMPORTED GLOBAL)
    add_dependencies(${name} ${name}_build)
    set_target_properties(${name} PROPERTIES
        IMPORTED_LOCATION "${library}"
        INTERFACE_INCLUDE_DIRECTORIES "${capi}/include"
        INTERFACE_COMPILE_DEFINITIONS "${definitions}")
    if(NOT DEFINED arg_RUST_TARGET AND UNIX)
        # Libraries that Rust's standard library needs.
        find_package(Threads REQUIRED)
        set_target_properties(${name} PROPERTIES
            INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
    endif()
endfunction()
