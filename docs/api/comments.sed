# Plain comments of the headers as doxygen wants to have them: /** */ in front of what they describe, /**< */ behind.

# headings of sections describe nothing
/^\/\* ----.*---- \*\/$/d
/^\/\* ----.*[^/]$/{
N
d
}

# <t10> is a mean and no tag, @ no command
/^ \*\|\/\*\|\*\//{
s/&/\&amp;/g
s/</\&lt;/g
s/>/\&gt;/g
s/@/\&#64;/g
}

# the first comment of a file is about the file
0,/^\/\* /s/^\/\* /\/** \@file\n * /

s/^\( *\)\/\* /\1\/** /
s/\([^ ].*\) \/\* /\1 \/**< /
