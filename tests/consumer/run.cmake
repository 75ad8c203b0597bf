# cmake -DBUILD=<build directory of genus> -DWORK=<scratch directory> -P run.cmake
# Installs genus, then configures, builds and runs the consumer against what was installed.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK}/build -G ${GENERATOR}
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer ${WORK}/part.stl)
if(NOT EXISTS ${WORK}/part.stl)
  message(FATAL_ERROR "the consumer wrote no file")
endif()
