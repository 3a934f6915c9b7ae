/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The totalforce authors
 *
 * Rewrites hidden symbols that an ELF object (64 bits) defines to default visibility, in place. A
 * shared library linked from it exports them. Undefined symbols stay as they are.
 *
 *   tfa_unhide OBJECT
 */
#include <elf.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

static void unhide(Elf64_Sym *symbols, size_t count)
{
    for (size_t k = 0; k < count; k++)
        if (ELF64_ST_VISIBILITY(symbols[k].st_other) == STV_HIDDEN &&
            symbols[k].st_shndx != SHN_UNDEF)
            symbols[k].st_other = (unsigned char)(symbols[k].st_other & ~3);
}

int main(int argc, char **argv)
{
    struct stat about;
    const int file = argc == 2 ? open(argv[1], O_RDWR) : -1;
    if (file < 0 || fstat(file, &about) != 0) {
        fputs("usage: tfa_unhide OBJECT\n", stderr);
        return 3;
    }
    unsigned char *bytes =
        mmap(NULL, (size_t)about.st_size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    const Elf64_Ehdr *header = (const void *)bytes;
    if (bytes == MAP_FAILED || memcmp(bytes, ELFMAG, SELFMAG) != 0 ||
        bytes[EI_CLASS] != ELFCLASS64) {
        fprintf(stderr, "%s: not an ELF object of 64 bits\n", argv[1]);
        return 2;
    }
    const Elf64_Shdr *sections = (const void *)(bytes + header->e_shoff);
    for (int k = 0; k < header->e_shnum; k++)
        if (sections[k].sh_type == SHT_SYMTAB)
            unhide((void *)(bytes + sections[k].sh_offset),
                   sections[k].sh_size / sizeof(Elf64_Sym));
    return munmap(bytes, (size_t)about.st_size) == 0 ? 0 : 2;
}
