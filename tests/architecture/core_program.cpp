// Linked with rt and control only, for the check of the symbols that these need. Never run.
int main() { return 0; }
