# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# Given: charted, the numbers of the methods in the chart, each between blanks.
#
# The marks of the methods, by their number: one shape for a family, dark for the first of it and
# light for the second, so that print in grey keeps them apart. Hollow: as solved; filled: refined.

array shape[32]; array colour[32]; array label[32]
do for [i=1:32] { shape[i] = 1; colour[i] = '#808080'; label[i] = '' }
define_mark = "shape[n] = s; colour[n] = c; label[n] = l"
n = 3;  s = 6;  c = '#000000'; l = 'aba';           eval(define_mark)
n = 2;  s = 4;  c = '#000000'; l = 'crba';          eval(define_mark)
n = 10; s = 12; c = '#F4A582'; l = 'cfa-cr';        eval(define_mark)
n = 9;  s = 12; c = '#8C2D04'; l = 'cfa';           eval(define_mark)
n = 11; s = 14; c = '#7B3294'; l = 'dca';           eval(define_mark)
n = 6+1; s = 8; c = '#56B4E9'; l = 'tfa-cr';        eval(define_mark)
n = 4;  s = 8;  c = '#08306B'; l = 'tfa';           eval(define_mark)
n = 8;  s = 4;  c = '#E69F00'; l = 'hessenberg';    eval(define_mark)
n = 31; s = 6;  c = '#0B3C8C'; l = 'auto';          eval(define_mark)
n = 12; s = 10; c = '#00441B'; l = 'scan';          eval(define_mark)
n = 13; s = 10; c = '#66C2A4'; l = 'scan-two-pass'; eval(define_mark)
n = 6;  s = 6;  c = '#0072B2'; l = 'propagation';   eval(define_mark)
n = 14; s = 6;  c = '#66A61E'; l = 'efpa';          eval(define_mark)
n = 15; s = 6;  c = '#D55E00'; l = 'pv-osimr';      eval(define_mark)
n = 5;  s = 8;  c = '#009E73'; l = 'tfa-one-sided'; eval(define_mark)
# peers; who they are is added behind this file
n = 24; s = 1;  c = '#CC3311'; l = '';              eval(define_mark)
n = 25; s = 2;  c = '#CC3311'; l = '';              eval(define_mark)

# those in the chart, as the key has them
order = ''
do for [m in "31 3 2 6 14 15 4 5 7 8 9 10 11 12 13 24 25"] { if (strstrt(charted, ' '.m.' ')) { order = order.' '.m } }
rhs_0 = 'qdd: torques of a random qdd'
rhs_1 = 'tau: random torques'
lambda = 0 # 1: Lambda^-1, which has no right-hand side
answer_name(lambda) = lambda ? 'Λ^{-1}, Frobenius norm' : 'qdd, 2-norm'
rhs_2 = 'gravity: at rest, no torques'
