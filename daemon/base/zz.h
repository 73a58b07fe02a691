#pragma once
#include <x86intrin.h>
#include <stdio.h>
extern unsigned long long zz_t[16], zz_s[16], zz_n;
static inline void zz(int i){ zz_t[i]=__rdtsc(); }
static inline void zz_end(int last){ if(zz_n++>2000) for(int i=1;i<=last;i++) {unsigned long long q=zz_t[i]-zz_t[i-1]; if(q<52000) zz_s[i]+=q;} if(zz_n==12000){ for(int i=1;i<=last;i++) fprintf(stderr,"  %d:%.2f",i,(double)zz_s[i]/9999/2.6/1e3); fprintf(stderr,"\n"); zz_n=2001; for(int i=1;i<=last;i++) zz_s[i]=0;} }
