# cpack runs this when packages are made: a bill of materials beside each.
cmake_policy(VERSION 3.25)
# The packages stand in a working folder still.
set(options --build ${CPACK_SINEW_BUILD} --into ${CPACK_PACKAGE_DIRECTORY})
if(CPACK_SINEW_SYSROOT)
  list(APPEND options --sysroot ${CPACK_SINEW_SYSROOT})
endif()
if(CPACK_SINEW_STATIC)
  list(APPEND options --static ${CPACK_SINEW_STATIC})
endif()
execute_process(COMMAND ${CPACK_SINEW_PYTHON} -B ${CPACK_SINEW_SOURCE}/tools/sbom.py ${CPACK_PACKAGE_FILES} ${options}
                COMMAND_ERROR_IS_FATAL ANY)
