/* SPDX-License-Identifier: Apache-2.0 */
/* The golden files, and one with effects beside them, as they would lie in flash. */
  .section .rodata
.macro golden name
  .balign 4
  .global golden_\name
golden_\name:
  .incbin "\name\().soakcal"
  .global golden_\name\()_end
golden_\name\()_end:
.endm
  golden fis
  golden whole
  golden mixed
  golden table
  golden couplings
  golden moving
