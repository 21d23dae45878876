/* Compiles the model of the macro MODEL (a header of this folder) to an FMU binary. */
#include "unit.h"
