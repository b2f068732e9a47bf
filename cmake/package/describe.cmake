# cpack runs this when packages are made: a bill of materials beside each.
cmake_policy(VERSION 3.25)
