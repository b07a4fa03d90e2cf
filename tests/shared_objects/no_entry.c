/* A shared object that is none of a procedural. */
int kinoraTestsNothing(void);
int kinoraTestsNothing(void) { return 0; }
