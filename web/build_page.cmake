# cmake -DNPM=... -DNODE=... -DWEB=... -DOUT=... -P build_page.cmake
# Builds the page into OUT/page_files.cpp. Where npm cannot bring what the page is made with, the
# program is built without its page, and says so; what is wrong in our own files ends the build.
set(modules ${WEB}/node_modules)
file(SHA256 ${WEB}/package-lock.json wanted)
set(installed "")
if(EXISTS ${modules}/.isolux-lock)
  file(READ ${modules}/.isolux-lock installed)
endif()
if(NOT installed STREQUAL wanted)
  execute_process(COMMAND ${NPM} ci --ignore-scripts --no-audit --no-fund --fetch-retries=1
                  WORKING_DIRECTORY ${WEB} RESULT_VARIABLE failed
                  OUTPUT_FILE ${OUT}/npm.log ERROR_FILE ${OUT}/npm.log)
  if(failed)
    message("isolux: the page is not built: npm could not fetch what web/package-lock.json names "
            "(log: ${OUT}/npm.log); `isolux view` will not run, all else does; to try again: "
            "rm ${OUT}/page_files.cpp")
    configure_file(${WEB}/no_page_files.cpp ${OUT}/page_files.cpp COPYONLY)
    return()
  endif()
  file(WRITE ${modules}/.isolux-lock ${wanted})
endif()
foreach(step "${NODE};node_modules/typescript/bin/tsc"
             "${NODE};node_modules/vite/bin/vite.js;build;--logLevel=warn;--emptyOutDir;--outDir;${OUT}/dist"
             "${NODE};write_page_files.mjs;${OUT}/dist;${OUT}/page_files.cpp")
  execute_process(COMMAND ${step} WORKING_DIRECTORY ${WEB} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
file(TOUCH ${OUT}/page_files.cpp)
