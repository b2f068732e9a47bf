// Linked with rt and control and nothing else, for the check of what that asks for. Never run.
int main() { return 0; }
