# Copies the library that cargo built last in FROM, with PROFILE for TARGET or for this machine, to TO.
#
# `.cargo/for-target` keeps builds of Debian's compiler in a separate folder.

file(GLOB built
    "${FROM}/${TARGET}/${PROFILE}/libstereo_selfcal_capi.a"
    "${FROM}/debian/${TARGET}/${PROFILE}/libstereo_selfcal_capi.a")
if(NOT built)
    message(FATAL_ERROR "cargo built no libstereo_selfcal_capi.a in ${FROM}")
endif()
list(GET built 0 newest)
foreach(library IN LISTS built)
    if(NOT newest IS_NEWER_THAN library)
        set(newest "${library}")
    endif()
endforeach()
execute_process(
    COMMAND ${CMAKE_COMMAND} -E copy_if_different "${newest}" "${TO}" COMMAND_ERROR_IS_FATAL ANY)
