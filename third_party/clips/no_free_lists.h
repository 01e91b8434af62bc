// Read before memalloc.c where CLIPS is to take and free each block of memory by itself (MEM_TABLE_SIZE=0).
// Its ReleaseMem counts down from MEM_TABLE_SIZE - 1 all the same, which must not be below zero: to the
// preprocessor this name is 0, as any that it does not know, and to the compiler it is 1.
enum { CLIPS_NO_FREE_LISTS = 1 };
#undef MEM_TABLE_SIZE
#define MEM_TABLE_SIZE CLIPS_NO_FREE_LISTS
