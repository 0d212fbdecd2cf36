import sys; sys.path.insert(0,'/work/wt'); sys.path.insert(0,'/work/wt/tables_notes')
from diag import *
import matplotlib; matplotlib.use("Agg"); import matplotlib.pyplot as plt
def loop(w,f,dur,out,k0=(),nmax=3,**k):
    s,F,K,h,c=base("re25-118743",w,**k)
    rows=contacts("re25-118743",f,w,dur,k0,**k)
    cell=2*math.pi/10000; T=1e-6
    con=rows[:,C.CONTACT]; n=len(con); b=np.r_[0,np.flatnonzero(np.diff(con))+1,n]
    fig,ax=plt.subplots(2,nmax,figsize=(7*nmax,12)); j=0
    for a,e in zip(b[:-1],b[1:]):
        if con[a] and e-a>20000 and j<nmax:
            sl=slice(a,e,20); x=rows[sl,C.X]/cell; Fk=-rows[sl,C.TORQUE]/K/cell
            ax[0,j].plot(x,Fk,lw=.5); ax[0,j].plot(x,x,'k:',lw=.5); ax[0,j].grid()
            tt=np.arange(a,e,20)*T
            ax[1,j].plot(tt,(x-Fk),lw=.5,label="x-F/K"); ax[1,j].plot(tt,rows[sl,C.CORRECTION],lw=.5,label="c")
            ax[1,j].plot(tt,x/10,label="x/10"); ax[1,j].legend(); ax[1,j].grid(); j+=1
    plt.tight_layout(); plt.savefig(out,dpi=60)
if __name__=="__main__":
    loop(sys.argv[1],float(sys.argv[2]),float(sys.argv[3]),sys.argv[4])
