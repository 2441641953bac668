# The page of `isolux view` as a source file of the room `server`: built from web/ by npm, or, where
# there is no Node, a file that says there is no page.
find_program(NODE NAMES node nodejs)
find_program(NPM npm)
set(web ${PROJECT_SOURCE_DIR}/web)
set(page_folder ${PROJECT_BINARY_DIR}/page)
file(MAKE_DIRECTORY ${page_folder})
if(NODE AND NPM)
  file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS ${web}/src/* ${web}/public/*)
  add_custom_command(
    OUTPUT ${page_folder}/page_files.cpp
    COMMAND ${CMAKE_COMMAND} -DNODE=${NODE} -DNPM=${NPM} -DWEB=${web} -DOUT=${page_folder}
            -P ${web}/build_page.cmake
    DEPENDS ${page_sources} ${web}/index.html ${web}/package-lock.json ${web}/tsconfig.json
            ${web}/vite.config.js ${web}/write_page_files.mjs ${web}/build_page.cmake
    COMMENT "Building the page of isolux view" VERBATIM)
  target_sources(isolux_server PRIVATE ${page_folder}/page_files.cpp)
else()
  message(WARNING "isolux: the page is not built: there is no Node.js with npm here; `isolux view` "
                  "will not run, all else does; install nodejs and npm and build again")
  target_sources(isolux_server PRIVATE ${web}/no_page_files.cpp)
endif()
