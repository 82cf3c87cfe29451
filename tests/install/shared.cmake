# Links the libraries shared and uses their installed tree as run.cmake uses the static one's. Objects of the build are position-
# independent, so that they serve here, too: what is compiled with equal options is taken from there.
set(shared ${BUILD}/shared)
file(REMOVE_RECURSE ${shared})
separate_arguments(options UNIX_COMMAND "${OPTIONS}")
set(configure -S ${SOURCE} -B ${shared} -G Ninja -D BUILD_SHARED_LIBS=ON -D CAIRN_TESTS=OFF ${options}
              "-DCMAKE_CXX_COMPILER_LAUNCHER=${SOURCE}/tests/install/reuse_object\\;${BUILD}\\;${shared}")
set(build --build ${shared} -- --quiet)
foreach(step configure build)
  execute_process(COMMAND ${CMAKE_COMMAND} ${${step}} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "cmake ${${step}}\n${output}")
  endif()
endforeach()
set(BUILD ${shared})
include(${SOURCE}/tests/install/run.cmake)
