# The C library of stereo-selfcal, built by cargo and imported.
#
#   include(path/to/core/capi/cmake/StereoSelfcal.cmake)
#   stereo_selfcal_add_library(stereo_selfcal)
#   target_link_libraries(my_program PRIVATE stereo_selfcal)
#
# stereo_selfcal_add_library(NAME [RUST_TARGET TRIPLE] [CAPACITY N])
#
#   RUST_TARGET  for a bare-metal target, such as thumbv7em-none-eabihf for a Cortex-M4F or -M7; left out
#                for the machine that builds.
#   CAPACITY     correspondences a pair: 64, 128, 256 (the default), 512 or 1024.
#
# Cargo's files go to the build folder, or to STEREO_SELFCAL_TARGET_DIR. One capacity and one target a
# build folder.

set(STEREO_SELFCAL_CAPI "${CMAKE_CURRENT_LIST_DIR}/.." CACHE INTERNAL "")
set(STEREO_SELFCAL_TARGET_DIR "${CMAKE_BINARY_DIR}/cargo" CACHE PATH "Where cargo puts its files")

function(stereo_selfcal_add_library name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "RUST_TARGET;CAPACITY" "")
    if(DEFINED arg_UNPARSED_ARGUMENTS)
        message(FATAL_ERROR "stereo_selfcal_add_library: what is '${arg_UNPARSED_ARGUMENTS}'?")
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

    get_filename_component(capi "${STEREO_SELFCAL_CAPI}" REALPATH)
    get_filename_component(root "${capi}/../.." REALPATH)
    set(what --package stereo-selfcal-capi ${features} --crate-type staticlib)
    if(DEFINED arg_RUST_TARGET)
        set(build "${root}/.cargo/for-target" ${arg_RUST_TARGET} rustc ${what})
    else()
        set(build cargo rustc --release --locked ${what})
    endif()

    # Cargo knows best whether anything has changed: it is always asked.
    set(library "${CMAKE_BINARY_DIR}/libstereo_selfcal.a")
    add_custom_target(${name}_build
        COMMAND ${CMAKE_COMMAND} -E env "CARGO_TARGET_DIR=${STEREO_SELFCAL_TARGET_DIR}" ${build}
        COMMAND ${CMAKE_COMMAND}
            "-DFROM=${STEREO_SELFCAL_TARGET_DIR}" "-DTARGET=${arg_RUST_TARGET}" "-DTO=${library}"
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
        # What Rust's standard library asks for.
        find_package(Threads REQUIRED)
        set_target_properties(${name} PROPERTIES
            INTERFACE_LINK_LIBRARIES "Threads::Threads;${CMAKE_DL_LIBS};m")
    endif()
endfunction()
