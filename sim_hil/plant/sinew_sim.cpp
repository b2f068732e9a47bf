#include "sim_hil/plant/render_test.hpp"
int main(int argc, char** argv) { return sinew::plant::render_test(argc > 1 ? argv[1] : "frames", 320, 240); }
