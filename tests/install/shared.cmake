# Builds the libraries shared, several files in a unit, and uses their installed tree as run.cmake uses the static one's.
# A local name that two files of a unit define shows here. Nothing is optimised, so that it takes a fraction of the build's time.
set(shared ${BUILD}/shared)
set(configure -S ${SOURCE} -B ${shared} -G Ninja -D BUILD_SHARED_LIBS=ON -D CAIRN_UNITY=ON -D CAIRN_TESTS=OFF
              -D CMAKE_BUILD_TYPE=Debug -D CMAKE_CXX_FLAGS_DEBUG=-O0)
set(build --build ${shared} -- --quiet)
foreach(step configure build)
  execute_process(COMMAND ${CMAKE_COMMAND} ${${step}} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "cmake ${${step}}\n${output}")
  endif()
endforeach()
set(BUILD ${shared})
include(${SOURCE}/tests/install/run.cmake)
