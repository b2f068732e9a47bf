# cpack runs this when it makes packages: writes a bill of materials for each.
cmake_policy(VERSION 3.25)
# The packages are still in a working folder.
set(options --build ${CPACK_SINEW_BUILD} --into ${CPACK_PACKAGE_DIRECTORY})
if(CPACK_SINEW_SYSROOT)
  list(APPEND options --sysroot ${CPACK_SINEW_SYSROOT})
endif()
if(CPACK_SINEW_STATIC)
  list(APPEND options --static ${CPACK_SINEW_STATIC})
endif()
execute_process(COMMAND ${CPACK_SINEW_PYTHON} -B ${CPACK_SINEW_SOURCE}/tools/sbom.py ${CPACK_PACKAGE_FILES} ${options}
                COMMAND_ERROR_IS_FATAL ANY)
