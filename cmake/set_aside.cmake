# Code that no thread of a robot's loops runs stands side by side in the program, and hal::lock_process_memory() leaves it
# out: commands, their files, and the libraries that read command lines, JSON and TOML. Only names that belong to these
# are listed; a function that a loop may share with them, such as one of the standard library's, stays where it is.
# GNU ld adds the script to its own (INSERT in the manual of ld).

# Also part of the installed package (SinewConfig.cmake): nothing but SINEW_SET_ASIDE is left in the caller's scope.

# sinew_set_aside_of(ARCHIVE NAMESPACE ...): appends to `lines` the functions of these namespaces in an archive, and templates
# of their types.
function(sinew_set_aside_of archive)
  foreach(space IN LISTS ARGN)
    foreach(name _ZN${space} _ZNK${space} _ZZN${space} _ZZNK${space} _ZNSt*${space} _ZNKSt*${space} _ZSt*${space})
      string(APPEND lines "    ${archive}(.text.${name}*)\n")
    endforeach()
  endforeach()
  set(lines "${lines}" PARENT_SCOPE)
endfunction()

# sinew_set_aside(FILE): writes the script.
function(sinew_set_aside file)
  set(lines "")
  foreach(room apps apps_bag apps_calibrate apps_command apps_deploy apps_live apps_replay apps_robot apps_robot_file apps_toml apps_sweep_runs apps_view)
    sinew_set_aside_of("*libsinew_${room}.a:*" 5sinew3app)
  endforeach()
  sinew_set_aside_of("*libsinew_apps_sweep.a:*" 5sinew5sweep)
  sinew_set_aside_of("*libsinew_tap.a:*" 5sinew3tap)
  sinew_set_aside_of("*libsinew_record.a:*" 5sinew6record)
  sinew_set_aside_of("*libsinew_dataset.a:*" 5sinew7dataset)
  sinew_set_aside_of("*" 3CLI 8nlohmann 4toml 3fmt)
  # Replays, and what is checked before the start; members of classes, which a loop may call, have another name in between.
  foreach(name _ZN5sinew6record*Replay _ZNK5sinew6record*Replay _ZN5sinew6record*Comparison _ZN5sinew3hal??check_
               _ZN5sinew7drivers??check_)
    string(APPEND lines "    *(.text.${name}*)\n")
  endforeach()
  file(CONFIGURE OUTPUT ${file} @ONLY CONTENT "SECTIONS
{
  .set_aside : ALIGN(CONSTANT(MAXPAGESIZE))
  {
    sinew_set_aside_begin = .;
@lines@    . = ALIGN(CONSTANT(MAXPAGESIZE));
    sinew_set_aside_end = .;
  }
}
INSERT BEFORE .text;
")
endfunction()

set(SINEW_SET_ASIDE ${CMAKE_BINARY_DIR}/set_aside.ld)
sinew_set_aside(${SINEW_SET_ASIDE})
