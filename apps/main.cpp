// sinew: runs, checks and shows robots.
#include "apps/command_line.hpp"
#include "apps/module_list.hpp"

int main(int argc, char** argv) { return sinew::app::command_line(argc, argv, sinew::app::all_modules()); }
