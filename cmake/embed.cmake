# sinew_embed(OUTPUT FOLDER): a source that holds the files FOLDER/*.in as text; NAME in a file's name becomes @NAME@.
function(sinew_embed output folder)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.in)
  set(entries "")
  foreach(file ${files})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    file(READ ${folder}/${file} text)
    string(REGEX REPLACE "[.]in$" "" path ${file})
    string(REPLACE NAME @NAME@ path ${path})
    string(APPEND entries "    {\"${path}\", R\"__(${text})__\"},\n")
  endforeach()
  file(CONFIGURE OUTPUT ${output} @ONLY NEWLINE_STYLE UNIX CONTENT "#include \"apps/new_project.hpp\"

namespace sinew::app {

std::span<const ProjectFile> project_files() {
  static constexpr ProjectFile kFiles[] = {
@entries@  };
  return kFiles;
}

}  // namespace sinew::app
")
endfunction()

# sinew_embed_scripts(OUTPUT FOLDER): a source with board_script(name), the text of FOLDER/*.sh.
function(sinew_embed_scripts output folder)
  file(GLOB files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*.sh)
  set(entries "")
  foreach(file ${files})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    file(READ ${folder}/${file} text)
    string(REGEX REPLACE "[.]sh$" "" name ${file})
    string(APPEND entries "  if (name == \"${name}\") return R\"__(${text})__\";\n")
  endforeach()
  file(CONFIGURE OUTPUT ${output} @ONLY NEWLINE_STYLE UNIX CONTENT "#include \"apps/deploy/board_shell.hpp\"

namespace sinew::app {

std::string_view board_script(std::string_view name) {
@entries@  return {};
}

}  // namespace sinew::app
")
endfunction()

# sinew_embed_text(OUTPUT FILE NAMESPACE FUNCTION): a source with the function, which returns the file's text.
function(sinew_embed_text output file namespace function)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} text)
  file(CONFIGURE OUTPUT ${output} @ONLY NEWLINE_STYLE UNIX CONTENT "#include <string_view>

namespace @namespace@ {

std::string_view @function@();
std::string_view @function@() { return R\"__(@text@)__\"; }

}  // namespace @namespace@
")
endfunction()
