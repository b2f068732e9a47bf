# sinew_page(OUTPUT FOLDER): a source that holds the built page in FOLDER for monitor/page.hpp, each file as it is and as
# gzip. No node is needed: FOLDER is in the repository.
function(sinew_page output folder)
  file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${folder} ${folder}/*)
  list(SORT files)
  get_filename_component(place ${output} DIRECTORY)
  set(assembler "")
  set(symbols "")
  set(entries "")
  set(index 0)
  foreach(file ${files})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/${file})
    string(REGEX MATCH "[.][a-z]+$" ending ${file})
    if(ending STREQUAL .html)
      set(type "text/html; charset=utf-8")
    elseif(ending STREQUAL .js)
      set(type "text/javascript; charset=utf-8")
    elseif(ending STREQUAL .css)
      set(type "text/css; charset=utf-8")
    elseif(ending STREQUAL .svg)
      set(type "image/svg+xml")
    elseif(ending STREQUAL .txt)
      set(type "text/plain; charset=utf-8")
    else()
      message(FATAL_ERROR "${folder}/${file}: cmake/page.cmake knows no media type for '${ending}'")
    endif()
    set(packed ${place}/page/${file}.gz)
    get_filename_component(packed_folder ${packed} DIRECTORY)
    file(MAKE_DIRECTORY ${packed_folder})
    file(ARCHIVE_CREATE OUTPUT ${packed} PATHS ${folder}/${file} FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9)
    file(SHA256 ${folder}/${file} hash)
    string(SUBSTRING ${hash} 0 20 hash)
    foreach(kind plain packed)
      set(path ${packed})
      if(kind STREQUAL plain)
        set(path ${folder}/${file})
      endif()
      set(name sinew_page_${kind}_${index})
      string(APPEND assembler "    \".hidden ${name}, ${name}_end\\n.globl ${name}, ${name}_end\\n\"\n"
             "    \"${name}: .incbin \\\"${path}\\\"\\n${name}_end: .byte 0\\n\"\n")
      string(APPEND symbols "extern const std::byte ${name}[], ${name}_end[];\n")
    endforeach()
    string(APPEND entries "      {\"/${file}\", \"${type}\", \"\\\"${hash}\\\"\", {sinew_page_plain_${index}, sinew_page_plain_${index}_end},\n"
           "       {sinew_page_packed_${index}, sinew_page_packed_${index}_end}},\n")
    math(EXPR index "${index} + 1")
  endforeach()
  file(CONFIGURE OUTPUT ${output} @ONLY NEWLINE_STYLE UNIX CONTENT "#include \"monitor/page.hpp\"

asm(\".pushsection .rodata\\n\"
@assembler@    \".popsection\\n\");
extern \"C\" {
@symbols@}

namespace sinew::monitor {

std::span<const PageFile> page_files() {
  static const PageFile kFiles[] = {
@entries@  };
  return kFiles;
}

}  // namespace sinew::monitor
")
  list(TRANSFORM files PREPEND ${folder}/)
  set_source_files_properties(${output} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON OBJECT_DEPENDS "${files}")
endfunction()
